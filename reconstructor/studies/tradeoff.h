// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstructor/effort/limits.h"
#include "reconstructor/studies/experiment.h"

namespace sheen {

/// One way to set the model.
struct Setting {
  std::string name;  ///< what differs from the default, in the words of a scene file: "max_rank = 6"
  std::string part;  ///< which part of the sweep it belongs to: "rank", "surface map", ...
  SurfaceLightFieldOptions options;
};

/// What a setting costs and what it gains on held-out views.
struct TradeoffPoint {
  Setting setting;
  double image_ms = 0;   ///< median wall time per image
  double cpu_ms = 0;     ///< mean processor time per image, all threads
  double bytes = 0;      ///< of the patches' state
  double mean_rank = 0;  ///< terms per patch
  double psnr_db = 0, ssim = 0;
};

/// One setting at a time round `base`, and the combinations of rank and surface map that matter. `quick`: about a
/// third of them.
std::vector<Setting> tradeoff_settings(const SurfaceLightFieldOptions& base, bool quick);

/// `base`, and what it is without each of its parts or with the paper's way in its place: what the parts are worth.
std::vector<Setting> part_settings(const SurfaceLightFieldOptions& base);

/// The quicker effort levels of --budget, from level 1 on.
std::vector<Setting> effort_level_settings(const SurfaceLightFieldOptions& base);

TradeoffPoint measure_setting(const Experiment& experiment, const Setting& setting);

/// Indices of the points that no other one beats in both: none is as cheap with more `worth`, or cheaper with as much.
/// In the order of rising cost. Points with a value that is not finite are never among them.
std::vector<std::size_t> pareto_frontier(std::span<const double> cost, std::span<const double> worth);

struct TradeoffChoice {
  std::size_t index = 0;
  bool holds = true;  ///< false: no measured setting keeps all limits; this one comes nearest
};

/// With a PSNR asked for, the quickest setting (then the smallest) that reaches it within the limits; without, the best
/// one within the limits. Where the limits cannot be kept, the setting that exceeds them by the smallest factor; where
/// they leave no setting that reaches the PSNR, the best one within them. `points` must not be empty.
TradeoffChoice choose_setting(std::span<const TradeoffPoint> points, const Limits& limits);

}  // namespace sheen
