// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
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

/// Triangles by meshoptimizer's codec, which may begin a triangle at another corner; vertices by how they differ from
/// the fourth corner of the parallelogram over a triangle before. A vertex of no triangle is not stored. Not empty.
std::string encode_mesh(const GridMesh& mesh);

/// Throws std::runtime_error that says what is wrong.
GridMesh decode_mesh(std::string_view bytes);

}  // namespace sheen
