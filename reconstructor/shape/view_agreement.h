// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "reconstructor/shape/depth_map.h"
#include "reconstructor/shape/shape_view.h"

namespace sheen {

/// What one view shows of the surface that another has found.
struct PairAgreement {
  std::size_t of = 0, in = 0;       ///< the view that found it, the view that is asked
  double angle = 0;                 ///< between the two, seen from the object, rad
  int windows = 0;                  ///< places that are asked about
  int alike = 0;                    ///< of these: it shows the same there
  std::optional<double> across_px;  ///< how far aside of the poses' place it shows them, pixels of `in`: median of the
                                    ///< part that no depth explains; empty where too few places tell
  double share() const { return windows == 0 ? 0 : double(alike) / windows; }
};

/// Each view with those, twelve at most, that look from up to 35 degrees beside it. Only pairs with places to ask
/// about.
std::vector<PairAgreement> agreement_of_pairs(std::span<const ShapeView> views, std::span<const DepthMap> depths,
                                              const Eigen::Vector3d& middle);

/// The object, or the stage, moved between two views: those before agree among themselves, those after, too.
struct Split {
  std::size_t after = 0;          ///< the last view before it
  double within = 0, across = 0;  ///< mean share of windows alike in pairs of one side, and over the split
};
/// Where pairs on either side of a view agree best and pairs across least, angle by angle: pairs that lie far apart in
/// time often lie far apart in direction, and agree less. Empty where too few pairs cross.
std::optional<Split> best_split(std::span<const PairAgreement> pairs, std::size_t views);

}  // namespace sheen
