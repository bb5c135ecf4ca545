// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/light_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/angle.h"
#include "common/base/format.h"

namespace sheen {
namespace {

constexpr std::size_t kPrinted = 5;

std::string place(const LightState& light) {
  return format("(%.3f %.3f %.3f)", light.position.x(), light.position.y(), light.position.z());
}

nlohmann::json to_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

nlohmann::json light_report(const ModelSnapshot& snapshot, double tolerance) {
  const std::optional<LightAdvice> advice = snapshot.advise_next_light(tolerance);
  if (!advice) {
    std::printf("too few lights to say whether they are close enough\n");
    return nullptr;
  }
  const bool far = snapshot.light_kind() == LightKind::kDirectional;
  const double unit = far ? 1 / kDegree : 1;
  const char* const unit_name = far ? "degrees" : "m";
  const auto wide = static_cast<std::size_t>(
      std::count_if(advice->intervals.begin(), advice->intervals.end(), [](const auto& i) { return i.too_wide(); }));
  std::printf("%zu of %zu intervals between lights are too wide for errors of %g grey levels (99 %% of the pixels):\n",
              wide, advice->intervals.size(), tolerance);
  nlohmann::json intervals = nlohmann::json::array();
  for (std::size_t i = 0; i < wide; ++i) {
    const LightInterval& interval = advice->intervals[i];
    if (i < kPrinted)
      std::printf("  %s to %s: %.4g %s, %.1f grey levels half way; %.4g %s would do\n", place(interval.from).c_str(),
                  place(interval.to).c_str(), unit * interval.length, unit_name, interval.error,
                  unit * interval.required, unit_name);
    intervals.push_back({{"from", to_json(interval.from.position)},
                         {"to", to_json(interval.to.position)},
                         {"length", unit * interval.length},
                         {"required", unit * interval.required},
                         {"error_grey_levels", interval.error}});
  }
  if (wide > kPrinted) std::printf("  ...\n");
  std::printf("the next light is worth most at %s\n", place(advice->next).c_str());
  return {{"tolerance_grey_levels", tolerance},
          {"intervals", advice->intervals.size()},
          {"unit", unit_name},
          {"too_wide", intervals},
          {"worst_error_grey_levels", advice->intervals.front().error},
          {"next_light", to_json(advice->next.position)}};
}

}  // namespace sheen
