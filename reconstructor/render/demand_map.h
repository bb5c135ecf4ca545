// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/models/surface_demand.h"

namespace sheen {

/// What of a scene's demand a picture shows.
enum class Demand { kRank, kResolution, kBytes };
inline constexpr std::array<Demand, 3> kDemands{Demand::kRank, Demand::kResolution, Demand::kBytes};
const char* to_string(Demand demand);  ///< "rank", "resolution", "bytes"
float value_of(const SurfaceDemand& triangle, Demand demand);

/// Colours from little to much, dark to bright: 0..1, sRGB-encoded. Told apart by colour-blind people too.
inline constexpr int kDemandColours = 4;
Eigen::Vector3f demand_stop(int stop);
/// Between these, evenly spaced; `level` in 0..1.
Eigen::Vector3f demand_colour(float level);

/// Per triangle; empty where the model has no patches.
std::vector<SurfaceDemand> surface_demand(const ModelSnapshot& snapshot);

/// The same of one demand, brought to one scale.
class DemandMap {
 public:
  DemandMap(const ModelSnapshot& snapshot, Demand demand);

  bool empty() const { return levels_.empty(); }  ///< the model has no such parts
  /// The value at the bright end: what 98 of 100 triangles that images reached do not exceed.
  float most() const { return most_; }
  /// Per triangle: value / most, at most 1; below 0 where no image reached it.
  const std::vector<float>& levels() const { return levels_; }

 private:
  float most_ = 0;
  std::vector<float> levels_;
};

}  // namespace sheen
