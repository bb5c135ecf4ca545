// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sheen {

/// Samples of a triangle's surface map stand on a triangular lattice of `resolution` n: (i, j), i, j >= 0, i + j < n,
/// at barycentric weights (1 - (i + j) / (n - 1), i / (n - 1), j / (n - 1)) of its corners 0, 1, 2. A map "16x16" is n
/// = 16: the half of a 16x16 square that a triangle fills.
constexpr int lattice_samples(int resolution) {
  return resolution * (resolution + 1) / 2;
}

/// Index of lattice point (i, j): j runs fastest.
constexpr int lattice_index(int resolution, int i, int j) {
  return i * resolution - i * (i - 1) / 2 + j;
}

struct LatticePoint {
  int i, j;
};
/// The point with this index.
inline LatticePoint lattice_point(int resolution, int index) {
  // i (2n + 1 - i) / 2 <= index, of whole numbers so small that the root is exact where it is one
  const auto twice = static_cast<float>(2 * resolution + 1);
  const int i = static_cast<int>((twice - std::sqrt(twice * twice - 8 * static_cast<float>(index))) / 2);
  return {i, index - lattice_index(resolution, i, 0)};
}

/// The three lattice points round a place on a triangle and their weights (they sum to 1): linear interpolation.
struct LatticeStencil {
  int index[3];
  float weight[3];
};
/// u, v: barycentric weights of corners 1 and 2.
LatticeStencil lattice_stencil(int resolution, float u, float v);

/// The same at a point of another lattice, of resolution `at`.
inline LatticeStencil lattice_stencil(int resolution, int at, LatticePoint point) {
  const int last = at - 1, x = point.i * (resolution - 1), y = point.j * (resolution - 1);
  const int i = std::min(x / last, resolution - 2), j = std::min(y / last, resolution - 2 - i);
  const int a = x - i * last, b = y - j * last;  // within the cell, of `last`
  const auto weight = [&](int of_last) { return static_cast<float>(of_last) / static_cast<float>(last); };
  const int here = lattice_index(resolution, i, j), below = here + resolution - i;  // (i + 1, j)
  if (a + b <= last) return {{here, below, here + 1}, {weight(last - a - b), weight(a), weight(b)}};
  return {{below + 1, here + 1, below}, {weight(a + b - last), weight(last - a), weight(last - b)}};
}

/// Where the samples of a mesh's surface maps stand (000 sec. 4.1): triangle after triangle, each with its lattice
/// points in order. What an image shows and the colours that it gives are listed by sample in this order.
class MapLayout {
 public:
  /// `resolution[t]` >= 2 is the lattice resolution of triangle t. `filter_resolution[t]` is that for which images are
  /// prefiltered; empty: the same.
  explicit MapLayout(std::vector<std::uint8_t> resolution, std::vector<std::uint8_t> filter_resolution = {});

  std::size_t triangles() const { return resolution_.size(); }
  int resolution(std::size_t triangle) const { return resolution_[triangle]; }
  /// Of samples that stand for what is at their place, and not for all that is nearer to them than to others.
  int filter_resolution(std::size_t triangle) const {
    return filter_resolution_.empty() ? resolution_[triangle] : filter_resolution_[triangle];
  }
  /// Index of the triangle's first sample; of `triangles()`: the number of all samples.
  std::size_t first_sample(std::size_t triangle) const { return first_[triangle]; }
  std::size_t total_samples() const { return first_.back(); }
  std::size_t bytes() const;  ///< of memory

 private:
  std::vector<std::uint8_t> resolution_, filter_resolution_;
  std::vector<std::size_t> first_;
};

}  // namespace sheen
