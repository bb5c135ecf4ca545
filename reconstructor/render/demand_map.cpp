// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/demand_map.h"

#include <algorithm>

namespace sheen {
namespace {

constexpr double kBrightEnd = 0.98;  // of the triangles; a few that are far above would leave the others dark

}  // namespace

const char* to_string(Demand demand) {
  switch (demand) {
    case Demand::kRank:
      return "rank";
    case Demand::kResolution:
      return "resolution";
    case Demand::kBytes:
      break;
  }
  return "bytes";
}

float value_of(const SurfaceDemand& triangle, Demand demand) {
  switch (demand) {
    case Demand::kRank:
      return triangle.rank;
    case Demand::kResolution:
      return triangle.resolution;
    case Demand::kBytes:
      break;
  }
  return triangle.bytes;
}

Eigen::Vector3f demand_stop(int stop) {
  switch (stop) {
    case 0:
      return {0.07f, 0.10f, 0.30f};
    case 1:
      return {0.00f, 0.42f, 0.68f};
    case 2:
      return {0.10f, 0.70f, 0.50f};
    default:
      return {0.98f, 0.92f, 0.30f};
  }
}

Eigen::Vector3f demand_colour(float level) {
  const float place = std::clamp(level, 0.0f, 1.0f) * (kDemandColours - 1);
  const int below = std::min(static_cast<int>(place), kDemandColours - 2);
  const float part = place - static_cast<float>(below);
  return (1 - part) * demand_stop(below) + part * demand_stop(below + 1);
}

std::vector<SurfaceDemand> surface_demand(const ModelSnapshot& snapshot) {
  const auto* const demanding = dynamic_cast<const DemandingSurface*>(&snapshot);
  return demanding ? demanding->demand() : std::vector<SurfaceDemand>();
}

DemandMap::DemandMap(const ModelSnapshot& snapshot, Demand demand) {
  const std::vector<SurfaceDemand> triangles = surface_demand(snapshot);
  std::vector<float> reached;
  for (const SurfaceDemand& triangle : triangles)
    if (triangle.rank > 0) reached.push_back(value_of(triangle, demand));
  if (!reached.empty()) {
    const auto end =
        reached.begin() + static_cast<std::ptrdiff_t>(kBrightEnd * static_cast<double>(reached.size() - 1));
    std::nth_element(reached.begin(), end, reached.end());
    most_ = *end;
  }
  for (const SurfaceDemand& triangle : triangles)
    levels_.push_back(triangle.rank > 0 && most_ > 0 ? std::min(1.0f, value_of(triangle, demand) / most_) : -1);
}

}  // namespace sheen
