// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/model_settings.h"

#include <limits>

#include "common/base/errors.h"

namespace sheen {

SettingKey setting(std::string name, int& value, SettingTable table) {
  const auto set = [&value](const SettingValue& given) -> std::string {
    const auto* number = std::get_if<std::int64_t>(&given);
    if (!number || *number < std::numeric_limits<int>::min() || *number > std::numeric_limits<int>::max())
      return "must be a whole number";
    value = static_cast<int>(*number);
    return {};
  };
  return {std::move(name), table, [&value]() -> SettingValue { return std::int64_t{value}; }, set};
}

SettingKey setting(std::string name, double& value, SettingTable table) {
  const auto set = [&value](const SettingValue& given) -> std::string {
    if (const auto* whole = std::get_if<std::int64_t>(&given))
      value = static_cast<double>(*whole);
    else if (const auto* number = std::get_if<double>(&given))
      value = *number;
    else
      return "must be a number";
    return {};
  };
  return {std::move(name), table, [&value]() -> SettingValue { return value; }, set};
}

std::vector<SettingKey> ModelSettings::image_keys() {
  return {
      setting("hold_out_every", hold_out_every, SettingTable::kImages),
      setting("exposure", exposure,
              {{ExposureCompensation::kOff, "off"},
               {ExposureCompensation::kKnown, "known"},
               {ExposureCompensation::kEstimate, "estimate"}},
              SettingTable::kImages),
      setting("sampling", sampling, {{Sampling::kCubic, "cubic"}, {Sampling::kLinear, "linear"}},
              SettingTable::kImages),
      setting("erosion_px", visibility.erosion_px, SettingTable::kImages),
  };
}

void ModelSettings::require_valid_images() const {
  if (hold_out_every < 0 || hold_out_every == 1)
    throw ConfigError(
        "images: hold_out_every must be 0 (none) or at least 2: with 1 nothing would be left to learn from");
  if (!(visibility.erosion_px >= 0 && visibility.erosion_px <= 32))
    throw ConfigError("images: erosion_px must be 0..32");
}

void set(ModelSettings& settings, const std::string& key, const SettingValue& value) {
  for (const SettingKey& known : settings.keys()) {
    if (known.name != key) continue;
    if (const std::string demand = known.set(value); !demand.empty()) throw ConfigError(key + " " + demand);
    return;
  }
  throw ConfigError(std::string(settings.kind()) + " has no " + key);
}

}  // namespace sheen
