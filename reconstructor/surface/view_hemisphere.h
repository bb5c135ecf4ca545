// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "reconstructor/surface/hemisphere_frame.h"

namespace sheen {

/// Where a direction falls on the view map. Directions below the horizon are moved to the rim.
Eigen::Vector2f hemisphere_point(const Eigen::Matrix3f& frame, const Eigen::Vector3f& direction);

/// Delaunay triangulation of the captured directions on the view map, with the four corners of the map (+-1, +-1) as
/// points 0..3 and view j as point 4 + j.
struct ViewTriangulation {
  static constexpr int kCorners = 4;
  Eigen::Matrix2Xf points;
  std::vector<std::array<std::uint16_t, 3>> triangles;

  /// The triangle that holds the point and the point's barycentric weights in it; -1 outside the map.
  struct Location {
    int triangle = -1;
    std::array<float, 3> weights{};
  };
  Location locate(const Eigen::Vector2f& point) const;
  /// Area of a triangle; the whole map has 4.
  float area(int triangle) const;
};

/// Triangulates `directions`. Points that coincide to within 1e-3 share a place: the first one stands for all.
ViewTriangulation triangulate_views(const Eigen::Matrix3f& frame, const Eigen::Matrix3Xf& directions);

/// View-map interpolation as in the paper (000 sec. 4.2): weights of the captured views for a direction by Delaunay
/// barycentric coordinates. A triangle that reaches a corner of the map lies outside the hull of what was captured;
/// there the weights of its captured corners are used, which clamps to the hull's edge.
Eigen::VectorXf delaunay_weights(const ViewTriangulation& triangulation, const Eigen::Vector2f& point);

}  // namespace sheen
