// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/camera/posed_camera.h"
#include "reconstructor/light_field_file/mesh_coding.h"

namespace sheen {

// What a reader decides by: whole numbers, which are the same on every machine.

/// The largest whole number whose square is not larger. `square` < 2^62.
std::int64_t integer_root(std::int64_t square);

/// Where cameras stand, in steps of the mesh's grid from its origin; none further than 2^30 steps along an axis.
std::vector<GridMesh::Point> grid_eyes(const std::vector<PosedCamera>& cameras, const GridMesh& mesh);

/// The middle of the box round the points of a mesh.
GridMesh::Point box_centre(const GridMesh& mesh);

/// From `from` to `to`, of length 2^20.
std::array<std::int64_t, 3> grid_direction(const GridMesh::Point& from, const GridMesh::Point& to);
/// The same as a unit vector; +z where both are at one place.
Eigen::Vector3f unit_direction(const GridMesh::Point& from, const GridMesh::Point& to);

/// How squarely the vertices of a mesh face the cameras.
class GridFacing {
 public:
  static constexpr std::int64_t kOne = 1 << 12;

  explicit GridFacing(const GridMesh& mesh);
  /// The cosine between the vertex's normal and the direction to the eye, in parts of `kOne`.
  std::int64_t cosine(std::size_t vertex, const GridMesh::Point& eye) const;

 private:
  const std::vector<GridMesh::Point>& points_;
  std::vector<std::array<std::int64_t, 3>> normals_;  ///< per vertex, of length 2^20; 0 where no triangle has an area
};

}  // namespace sheen
