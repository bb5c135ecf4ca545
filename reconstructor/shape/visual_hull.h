// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <span>
#include <vector>

#include "common/parallel/for_each.h"
#include "reconstructor/shape/block_field.h"
#include "reconstructor/shape/shape_view.h"

namespace sheen {

/// Which points belong to a hull.
struct HullRule {
  int most_dissent = 0;    ///< as many of the views that see a point may have it in their background, ...
  double may_dissent = 0;  ///< ... or this share of them
  double must_see = 0.5;   ///< share of all views that must have it in their frame
  bool outlines = true;    ///< else these count for nothing

  int dissenters(std::size_t seeing) const {
    if (seeing < 2) return 0;
    return std::max(most_dissent, static_cast<int>(may_dissent * static_cast<double>(seeing)));
  }
};

/// What the outlines of all views leave of a box.
class VisualHull {
 public:
  VisualHull(std::span<const ShapeView> views, const Eigen::AlignedBox3d& box, const HullRule& rule);

  struct Place {
    float outside = 0;  ///< metres; negative inside
    int outlines = 0;   ///< views whose outlines tell of it: that have it in their frame, and not off a sheet
  };
  /// How far a point lies outside. Of a view i that is D_i z / f, with D_i the pixels from the outline at distance z
  /// and focal length f; of all views that tell of it the one after as many as may dissent, from the largest.
  Place at(const Eigen::Vector3d& point) const;
  float distance(const Eigen::Vector3d& point) const { return at(point).outside; }

  bool has_outlines() const { return outlines_ > 0; }
  int outlines() const { return outlines_; }  ///< views that have one
  const Eigen::AlignedBox3d& box() const { return box_; }

 private:
  struct View {
    Eigen::Matrix<float, 3, 4> pixel_from_object;  ///< of the centred point: (z u, z v, z)
    float metres_per_pixel = 0;                    ///< at distance 1
    ImageF
        outside;  ///< pixels from the outline, negative on the object, NaN off a sheet; empty where the view has none
    int width = 0, height = 0;
  };
  Eigen::AlignedBox3d box_;
  std::vector<View> views_;
  HullRule rule_;
  int outlines_ = 0;
};

/// Its distances on a lattice; far from its surface blocks are not stored.
BlockField hull_field(const VisualHull& hull, const Lattice& lattice, const ForEach& for_each);

/// A lattice of cubic cells that covers a box with a margin of two.
Lattice lattice_over(const Eigen::AlignedBox3d& box, double cell);

}  // namespace sheen
