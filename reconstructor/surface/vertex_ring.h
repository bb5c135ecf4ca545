// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/mesh.h"

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

/// The three lattice points round a place on a triangle and their weights (they sum to 1): linear interpolation.
struct LatticeStencil {
  int index[3];
  float weight[3];
};
/// u, v: barycentric weights of corners 1 and 2.
LatticeStencil lattice_stencil(int resolution, float u, float v);

/// A triangle as a member of the ring of one of its corners.
struct RingTriangle {
  std::uint32_t triangle;
  std::uint8_t corner;         ///< which of the triangle's corners is the ring's vertex
  std::uint32_t first_sample;  ///< of the triangle's samples among the ring's
};

/// All triangles round each vertex (000 sec. 4.1), which are drawn with the vertex's own interpolation between views;
/// each triangle belongs to the rings of its three corners. Samples of a ring: its triangles in order, each with its
/// lattice points in order; a sample has three rows (R, G, B), so row = 3 * sample + channel.
class VertexRings {
 public:
  /// `resolution[t]` >= 2 is the lattice resolution of triangle t.
  VertexRings(const Mesh& mesh, std::vector<std::uint8_t> resolution);

  std::size_t size() const { return first_.size() - 1; }  ///< one ring per vertex; may be empty
  std::span<const RingTriangle> ring(std::size_t vertex) const {
    return std::span(members_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }
  int ring_samples(std::size_t vertex) const { return ring_samples_[vertex]; }
  int resolution(std::size_t triangle) const { return resolution_[triangle]; }
  /// Index of the triangle's first sample among all triangles' samples.
  std::size_t first_sample(std::size_t triangle) const { return triangle_first_[triangle]; }
  std::size_t total_samples() const { return triangle_first_.back(); }
  /// The triangle's place in the ring of its corner.
  const RingTriangle& membership(std::size_t triangle, int corner) const {
    return members_[membership_[3 * triangle + corner]];
  }

 private:
  std::vector<std::uint8_t> resolution_;
  std::vector<std::size_t> first_;  ///< of a vertex's members
  std::vector<RingTriangle> members_;
  std::vector<int> ring_samples_;
  std::vector<std::size_t> triangle_first_;
  std::vector<std::uint32_t> membership_;
};

}  // namespace sheen
