// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene_config.h"

#include <toml++/toml.h>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "common/errors.h"

namespace sheen {
namespace {

/// Takes a value over; else says what it must be.
using Setter = std::function<std::string(const toml::node&)>;

Setter into(int& target) {
  return [&target](const toml::node& node) -> std::string {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || *value < std::numeric_limits<int>::min() || *value > std::numeric_limits<int>::max())
      return "must be a whole number";
    target = static_cast<int>(*value);
    return {};
  };
}

Setter into(double& target) {
  return [&target](const toml::node& node) -> std::string {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value) return "must be a number";
    target = *value;
    return {};
  };
}

Setter into(ExposureCompensation& target) {
  return [&target](const toml::node& node) -> std::string {
    const auto word = node.value_exact<std::string>();
    if (word == "off")
      target = ExposureCompensation::kOff;
    else if (word == "known")
      target = ExposureCompensation::kKnown;
    else if (word == "estimate")
      target = ExposureCompensation::kEstimate;
    else
      return "must be \"off\", \"known\" or \"estimate\"";
    return {};
  };
}

std::string place(const std::filesystem::path& file, const toml::source_region& source) {
  return file.string() + ":" + std::to_string(source.begin.line) + ": ";
}

std::string key_list(const std::map<std::string, Setter, std::less<>>& setters) {
  std::string list;
  for (const auto& [key, setter] : setters) list += (list.empty() ? "" : ", ") + key;
  return list;
}

}  // namespace

SceneConfig load_scene_config(const std::filesystem::path& file) {
  toml::table document;
  try {
    document = toml::parse_file(file.string());
  } catch (const toml::parse_error& error) {
    if (error.source().begin.line == 0) throw FileError(file.string(), std::string(error.description()));
    throw ConfigError(place(file, error.source()) + std::string(error.description()));
  }
  SceneConfig config;
  SurfaceLightFieldOptions& o = config.surface_light_field;
  const std::map<std::string, Setter, std::less<>> setters{
      {"surface_map", into(o.surface_map)},
      {"max_rank", into(o.ring.factor.max_rank)},
      {"tolerance", into(o.ring.factor.tolerance)},
      {"max_views", into(o.ring.max_views)},
      {"min_visible", into(o.ring.min_visible)},
      {"hold_out_every", into(o.hold_out_every)},
      {"exposure", into(o.exposure)},
      {"erosion_px", into(o.visibility.erosion_px)},
  };
  for (const auto& [section, content] : document) {
    if (section != "surface_light_field" || !content.is_table())
      throw ConfigError(place(file, content.source()) + "unknown section [" + std::string(section.str()) +
                        "]; a scene has [surface_light_field]");
    for (const auto& [key, value] : *content.as_table()) {
      const auto setter = setters.find(key.str());
      if (setter == setters.end())
        throw ConfigError(place(file, value.source()) + "unknown key " + std::string(key.str()) + "; [" +
                          std::string(section.str()) + "] has " + key_list(setters));
      if (const std::string demand = setter->second(value); !demand.empty())
        throw ConfigError(place(file, value.source()) + std::string(key.str()) + " " + demand);
    }
  }
  return config;
}

}  // namespace sheen
