// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "common/geometry/mesh.h"

namespace sheen {

/// From a point to the nearest point of a triangle, its edges and corners included; exact also for one without area.
double distance_to_triangle(const Eigen::Vector3d& point, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c);

/// Exact distances to a mesh's surface, by a tree of bounding boxes.
class SurfaceDistance {
 public:
  explicit SurfaceDistance(const Mesh& mesh);

  /// Of a point in the frame of the mesh's file, metres; infinity where the mesh has no triangle. Thread-safe.
  double to(const Eigen::Vector3d& point) const;

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    std::uint32_t first = 0, count = 0;  ///< of `triangles_`; no count: the next node and `second` are its children
    std::uint32_t second = 0;
  };
  std::uint32_t build(std::uint32_t first, std::uint32_t count);
  void nearest(std::uint32_t node, const Eigen::Vector3d& point, double& best) const;
  Eigen::Vector3d corner(std::uint32_t triangle, int c) const { return vertices_[triangles_[triangle][c]]; }

  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace sheen
