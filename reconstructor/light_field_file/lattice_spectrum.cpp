// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/lattice_spectrum.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>

#include "reconstructor/numerics/symmetric_eigen.h"
#include "reconstructor/surface/map_layout.h"

namespace sheen {
namespace {

constexpr int kLargestTriangle = 24, kLargestTile = 16;

/// Samples (i, j) with i in [0, rows) and j in [0, columns) of a tile, i + j < `diagonal`.
struct TileShape {
  int rows, columns, diagonal;
  auto operator<=>(const TileShape&) const = default;
  bool has(int i, int j) const { return i >= 0 && j >= 0 && i < rows && j < columns && i + j < diagonal; }
};

constexpr int kDirections[3][2] = {{1, 0}, {0, 1}, {1, -1}};

/// Of the edge from (i, j) in a direction, in ten thousandths. An equilateral lattice looks the same turned by a third,
/// a square one turned over: frequencies would come in pairs that no eigensolver tells apart the same way twice.
/// Weights that differ by direction, and a little from place to place, part them: of all lattices no two eigenvalues
/// are nearer to each other than 5e-4, so that rounding moves no entry of an eigenvector by more than 1e-11.
constexpr int weight(int i, int j, int direction) {
  constexpr int kByDirection[3] = {10000, 10500, 9600};
  return kByDirection[direction] + 10 * ((3 * i + 91 * j + 78 * direction) % 101 - 50);
}

/// Of entry `a` in the sum that decides on an eigenvector's sign, 0 to 1: by a multiplicative hash, so that no
/// eigenvector of any lattice has a sum nearer to zero than 8e-6 of what it could be.
double sign_weight(std::uint32_t a) {
  return std::ldexp(static_cast<double>(a * 2654435761u), -32);
}

std::shared_ptr<const Eigen::MatrixXf> frequencies(const TileShape& shape) {
  std::vector<std::array<int, 2>> points;
  std::map<std::array<int, 2>, int> index;
  for (int i = 0; i < shape.rows; ++i)
    for (int j = 0; j < shape.columns; ++j)
      if (shape.has(i, j)) {
        index[{i, j}] = static_cast<int>(points.size());
        points.push_back({i, j});
      }
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd laplacian = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index a = 0; a < n; ++a)
    for (int d = 0; d < 3; ++d) {
      const auto [i, j] = points[static_cast<std::size_t>(a)];
      const int k = i + kDirections[d][0], l = j + kDirections[d][1];
      if (!shape.has(k, l)) continue;
      const Eigen::Index b = index.at({k, l});
      const double joined = weight(i, j, d) / 10000.0;
      laplacian(a, a) += joined;
      laplacian(b, b) += joined;
      laplacian(a, b) -= joined;
      laplacian(b, a) -= joined;
    }
  const SymmetricEigen eigen = symmetric_eigen(laplacian);
  Eigen::MatrixXd vectors = eigen.vectors.rowwise().reverse();  // the smoothest first
  for (Eigen::Index f = 0; f < n; ++f) {
    double sum = 0;
    for (Eigen::Index a = 0; a < n; ++a) sum += vectors(a, f) * sign_weight(static_cast<std::uint32_t>(a));
    if (sum < 0) vectors.col(f) *= -1;
  }
  return std::make_shared<const Eigen::MatrixXf>(vectors.cast<float>());
}

using Shapes = std::map<TileShape, std::shared_ptr<const Eigen::MatrixXf>>;

std::shared_ptr<const LatticeSpectrum> make_spectrum(int resolution, Shapes& shapes) {
  auto spectrum = std::make_shared<LatticeSpectrum>();
  const int parts = resolution <= kLargestTriangle ? 1 : (resolution + kLargestTile - 1) / kLargestTile,
            side = (resolution + parts - 1) / parts;
  for (int top = 0; top < resolution; top += side)
    for (int left = 0; top + left < resolution; left += side) {
      const TileShape shape{std::min(side, resolution - top), std::min(side, resolution - left),
                            std::min(resolution - top - left, 2 * side)};
      LatticeSpectrum::Tile tile;
      for (int i = 0; i < shape.rows; ++i)
        for (int j = 0; j < shape.columns; ++j)
          if (shape.has(i, j)) tile.samples.push_back(lattice_index(resolution, top + i, left + j));
      if (!shapes.contains(shape)) shapes[shape] = frequencies(shape);
      tile.vectors = shapes[shape];
      spectrum->tiles.push_back(std::move(tile));
    }
  return spectrum;
}

}  // namespace

const LatticeSpectrum& lattice_spectrum(int resolution) {
  static std::mutex mutex;
  static std::map<int, std::shared_ptr<const LatticeSpectrum>> known;
  static Shapes shapes;  // large lattices have tiles in common
  const std::lock_guard lock(mutex);
  auto& spectrum = known[resolution];
  if (!spectrum) spectrum = make_spectrum(resolution, shapes);
  return *spectrum;
}

}  // namespace sheen
