// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene_config.h"

#include <toml++/toml.h>
#include <functional>
#include <map>
#include <string>

#include "common/errors.h"

namespace sheen {
namespace {

using Setter = std::function<bool(const toml::node&)>;  // false: the value has the wrong type

template <typename T>
Setter into(T& target) {
  return [&target](const toml::node& node) {
    const auto value = node.value_exact<std::conditional_t<std::is_integral_v<T>, std::int64_t, double>>();
    if (!value) return false;
    target = static_cast<T>(*value);
    return true;
  };
}

Setter into(ExposureCompensation& target) {
  return [&target](const toml::node& node) {
    const auto word = node.value_exact<std::string>();
    if (word == "off")
      target = ExposureCompensation::kOff;
    else if (word == "known")
      target = ExposureCompensation::kKnown;
    else if (word == "estimate")
      target = ExposureCompensation::kEstimate;
    else
      return false;
    return true;
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
      if (!setter->second(value))
        throw ConfigError(place(file, value.source()) + std::string(key.str()) + " has a value of the wrong type");
    }
  }
  return config;
}

}  // namespace sheen
