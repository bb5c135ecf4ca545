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

/// Throws std::runtime_error that says what is wrong.
GridMesh decode_mesh(std::string_view bytes);

}  // namespace sheen
