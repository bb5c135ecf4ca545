// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/mesh.h"

namespace sheen {

/// A mesh whose vertices stand on a grid.
struct GridMesh {
  using Point = std::array<std::int32_t, 3>;

  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  float step = 1;
  std::vector<Point> points;
  std::vector<Triangle> triangles;

  Mesh mesh() const;
};

/// Of two points within 2^30 of each other.
inline std::int64_t squared_distance(const GridMesh::Point& a, const GridMesh::Point& b) {
  std::int64_t sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t d = std::int64_t{a[axis]} - b[axis];
    sum += d * d;
  }
  return sum;
}

/// A mesh in the order in which it is coded. A vertex of no triangle is not stored.
struct CodedMesh {
  GridMesh grid;                            ///< as a reader has it
  std::vector<std::uint32_t> old_vertex;    ///< for each vertex, its index before
  std::vector<std::uint32_t> old_triangle;  ///< for each triangle
  std::vector<std::uint8_t> first_corner;   ///< for each triangle: which corner it had there its corner 0 was
  std::string bytes;
};

/// The surface grows from one triangle over its open edges, vertex after vertex: for each edge it is coded whether a
/// triangle follows and which its third corner is, mostly one that the surface has beside the edge, or a new one. A new
/// vertex is coded by how it differs from the fourth corner of the parallelogram over the triangle before. Takes any
/// triangles, of surfaces or not. Points within 2^21 of 0.
CodedMesh encode_mesh(const GridMesh& mesh);

/// Throws std::runtime_error that says what is wrong.
GridMesh decode_mesh(std::string_view bytes);

}  // namespace sheen
