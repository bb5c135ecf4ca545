// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "reconstructor/evaluation/held_out.h"
#include "reconstructor/models/baselines.h"

namespace sheen {

/// How far what a model says of its own errors (`SurfaceQuality::error`) tells places apart in views that it never saw;
/// how far its sum is true says `CalibrationCheck`.
struct ErrorRanking {
  /// Spearman's correlation of the error predicted of a triangle in a view with the RMS error there, over all that show
  /// four pixels or more away from the edge of the object; NaN where there are none.
  double rank_correlation = 0;
  double other_rank_correlation = 0;  ///< the same of the other heuristic
};
/// `other`: another way to say how well the surface is known, which the model's is compared with.
ErrorRanking judge_error_ranking(const std::vector<HeldOutView>& views, const Appearance& model,
                                 const BaselineHeuristic& other, const RayPainter& painter);

/// Of two lists of the same length, equal values sharing their ranks; NaN where one of them does not vary.
double rank_correlation(std::span<const double> a, std::span<const double> b);

}  // namespace sheen
