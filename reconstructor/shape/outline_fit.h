// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/mesh.h"
#include "reconstructor/shape/shape_view.h"
#include "reconstructor/shape/view_agreement.h"

namespace sheen {

/// How an outline fits a mesh.
struct OutlineFit {
  double overlap = 0;       ///< of what may be the object in the view with the mesh: intersection over union
  double thin_missing = 0;  ///< of the object's pixels: in parts a few pixels wide that the mesh has not
};
/// Per view; empty where it has no outline, or only one before a stage's sheet, which is rough. `thin_px`: so wide a
/// part may be and be lost.
std::vector<std::optional<OutlineFit>> outline_fits(std::span<const ShapeView> views, const Mesh& mesh, double thin_px);

/// Where outlines that do not agree with each other part in two that do, in the order of the views: what they show
/// moved. Empty where they do not. `box`: that the object is in.
std::optional<Split> split_of_outlines(std::span<const ShapeView> views, const Eigen::AlignedBox3d& box);

}  // namespace sheen
