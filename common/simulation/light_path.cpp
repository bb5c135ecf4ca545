// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/light_path.h"

#include <algorithm>
#include <cmath>

#include "common/base/angle.h"
#include "common/base/errors.h"
#include "common/datasets/light_list.h"

namespace sheen {
namespace {

constexpr double kDistance_m = 0.9, kPlaneSide_m = 1;
constexpr double kLowest_deg = 15, kHighest_deg = 80;

/// Turns and rises so that neighbours along the spiral are about as far apart as its turns.
Eigen::Vector3d on_dome(int frame, int frames) {
  const double low = std::sin(kLowest_deg * kDegree), high = std::sin(kHighest_deg * kDegree);
  const double spacing = std::sqrt(2 * M_PI * (high - low) / frames);
  const double elevation = std::asin(low + (high - low) * (frame + 0.5) / frames);
  const double azimuth = 2 * M_PI * (elevation - kLowest_deg * kDegree) / spacing;
  return kDistance_m * Eigen::Vector3d(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                                       std::sin(elevation));
}

Eigen::Vector3d on_plane(int frame, int frames) {
  const int columns = static_cast<int>(std::ceil(std::sqrt(frames))), rows = (frames + columns - 1) / columns;
  const int row = frame / columns, step = frame % columns, column = row % 2 == 0 ? step : columns - 1 - step;
  const auto along = [](int at, int of) { return of > 1 ? kPlaneSide_m * (double(at) / (of - 1) - 0.5) : 0.0; };
  return {along(column, columns), along(row, rows), kDistance_m};
}

Eigen::Vector3d on_lines(const std::vector<LitView>& places, int frame, int frames) {
  const double at = frames > 1 ? double(frame) * double(places.size() - 1) / (frames - 1) : 0;
  const auto before = std::min(static_cast<std::size_t>(at), places.size() - 1),
             after = std::min(before + 1, places.size() - 1);
  const double part = at - double(before);
  return (1 - part) * places[before].light.position + part * places[after].light.position;
}

}  // namespace

std::vector<LightState> light_path(const std::string& shape, int frames) {
  const bool dome = shape == "dome", plane = shape == "plane";
  std::vector<LitView> places;
  if (!dome && !plane) {
    if (!shape.ends_with(".lp")) throw ConfigError("light path \"" + shape + "\" is not one of dome, plane, FILE.lp");
    places = load_lights(shape);
    if (places.front().light.kind != LightKind::kPoint)
      throw ConfigError(
          shape + ": a lamp's path has positions in metres, not directions of length 1; its first line may say \"" +
          std::to_string(places.size()) + " positions\"");
  }
  std::vector<LightState> path;
  for (int i = 0; i < frames; ++i)
    path.push_back({.kind = LightKind::kPoint,
                    .position = dome    ? on_dome(i, frames)
                                : plane ? on_plane(i, frames)
                                        : on_lines(places, i, frames)});
  return path;
}

}  // namespace sheen
