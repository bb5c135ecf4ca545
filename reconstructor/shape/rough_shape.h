// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/geometry/mesh.h"
#include "common/geometry/ray_scene.h"
#include "reconstructor/shape/shape_view.h"

namespace sheen {

/// A mesh that is about where the object is and about as large: a scan that is coarse or a little off, a box round it.
/// What lies beside it in a view, by more than it may be wrong, is background: the table that the object stands on, and
/// the room.
class RoughShape {
 public:
  explicit RoughShape(const Mesh& mesh);
  /// Of a view that has none of its own. Where the mesh may end, all is unknown.
  void mark_outline(ShapeView& view) const;

 private:
  RayScene scene_;
  Eigen::Vector3d origin_, middle_;
  double slack_;  ///< by which it may be wrong, metres
};

}  // namespace sheen
