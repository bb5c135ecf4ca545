// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>

#include "reconstructor/shape/shape_images.h"
#include "reconstructor/shape/view_agreement.h"
#include "reconstructor/shape/visual_hull.h"

namespace sheen {

/// A hull in a box that fits it.
struct ObjectHull {
  VisualHull hull;
  bool coherent = false;  ///< outlines and hull are of one object: they are believed
};

/// Where the object is.
struct ObjectPlace {
  Eigen::AlignedBox3d box;     ///< that holds it
  Eigen::AlignedBox3d space;   ///< that was looked in
  std::optional<Split> moved;  ///< outlines show it at two places
};
/// From small images: on the stage, where that is known. Throws Error where there is nothing.
ObjectPlace find_place(ShapeImages& images);

/// One dissenter for a mask that is off, where outlines and hull are of one object; else a fifth. Throws Error where
/// the outlines have no place in common.
ObjectHull find_hull(std::span<const ShapeView> views, const Eigen::AlignedBox3d& seen);

/// On a lattice with so many cells along the longest side of its box.
BlockField hull_with_cells(const VisualHull& hull, double cells);
inline constexpr double kRangeCells = 128;  ///< of a hull that bounds where depth is searched

}  // namespace sheen
