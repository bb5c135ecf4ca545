// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/scene_config.h"

#include <toml++/toml.h>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "common/base/errors.h"
#include "common/base/files.h"

namespace sheen {
namespace {

/// One key of a scene file and the option behind it.
struct Key {
  std::function<std::string(const toml::node&)> set;  ///< takes a value over; else says what it must be
  std::function<std::string()> text;                  ///< the present value as TOML
};
using Keys = std::map<std::string, Key, std::less<>>;

Key into(int& target) {
  const auto set = [&target](const toml::node& node) -> std::string {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || *value < std::numeric_limits<int>::min() || *value > std::numeric_limits<int>::max())
      return "must be a whole number";
    target = static_cast<int>(*value);
    return {};
  };
  return {set, [&target] { return std::to_string(target); }};
}

Key into(double& target) {
  const auto set = [&target](const toml::node& node) -> std::string {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value) return "must be a number";
    target = *value;
    return {};
  };
  return {set, [&target] {
            char text[32];
            std::snprintf(text, sizeof text, "%.9g", target);
            return std::string(text);
          }};
}

Key into(ExposureCompensation& target) {
  const auto set = [&target](const toml::node& node) -> std::string {
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
  return {set, [&target]() -> std::string {
            if (target == ExposureCompensation::kOff) return "\"off\"";
            return target == ExposureCompensation::kKnown ? "\"known\"" : "\"estimate\"";
          }};
}

Key into(Sampling& target) {
  const auto set = [&target](const toml::node& node) -> std::string {
    const auto word = node.value_exact<std::string>();
    if (word != "cubic" && word != "linear") return "must be \"cubic\" or \"linear\"";
    target = word == "cubic" ? Sampling::kCubic : Sampling::kLinear;
    return {};
  };
  return {set, [&target]() -> std::string { return target == Sampling::kCubic ? "\"cubic\"" : "\"linear\""; }};
}

Keys keys_of(SurfaceLightFieldOptions& o) {
  return {
      {"surface_map", into(o.surface_map)},
      {"map_scale", into(o.map_scale)},
      {"sampling", into(o.sampling)},
      {"max_rank", into(o.ring.factor.max_rank)},
      {"internal_rank", into(o.ring.factor.internal_rank)},
      {"block", into(o.ring.factor.block)},
      {"tolerance", into(o.ring.factor.tolerance)},
      {"max_views", into(o.ring.max_views)},
      {"repeat_angle", into(o.ring.repeat_angle)},
      {"min_visible", into(o.ring.min_visible)},
      {"hold_out_every", into(o.hold_out_every)},
      {"exposure", into(o.exposure)},
      {"erosion_px", into(o.visibility.erosion_px)},
  };
}

std::string place(const std::filesystem::path& file, const toml::source_region& source) {
  return file.string() + ":" + std::to_string(source.begin.line) + ": ";
}

/// Where the key stands that a broken rule ("surface light field: max_rank must be ...") begins with.
std::string place_of_rule(const std::filesystem::path& file, const toml::table& document, const std::string& rule) {
  const toml::table* section = document["surface_light_field"].as_table();
  if (!section) return file.string() + ": ";
  for (const auto& [key, value] : *section)
    if (rule.find(": " + std::string(key.str()) + " ") != std::string::npos) return place(file, value.source());
  return file.string() + ": ";
}

std::string key_list(const Keys& keys) {
  std::string list;
  for (const auto& [key, unused] : keys) list += (list.empty() ? "" : ", ") + key;
  return list;
}

/// All rungs of the ladder, as `tradeoff` measured them.
MeasuredLadder ladder_of(const toml::node& rungs, const std::filesystem::path& file) {
  const auto fail = [&](const toml::node& at) {
    throw ConfigError(place(file, at.source()) + "[[rung]]: takes image_ms above 0 and psnr_db, " +
                      std::to_string(effort_ladder().size()) + " times; `tradeoff --out` writes them");
  };
  MeasuredLadder ladder;
  const toml::array* list = rungs.as_array();
  if (!list || list->size() != effort_ladder().size()) fail(rungs);
  for (const toml::node& entry : *list) {
    const toml::table* table = entry.as_table();
    if (!table || table->size() != 2) fail(entry);
    const auto ms = (*table)["image_ms"].value<double>(), db = (*table)["psnr_db"].value<double>();
    if (!ms || !db || !(*ms > 0) || !std::isfinite(*ms) || !std::isfinite(*db)) fail(entry);
    ladder.push_back({*ms, *db});
  }
  return ladder;
}

}  // namespace

SceneConfig load_scene_config(const std::filesystem::path& file) {
  return parse_scene_config(read_file(file), file);
}

SceneConfig parse_scene_config(std::string_view text, const std::filesystem::path& file) {
  toml::table document;
  try {
    document = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    throw ConfigError(place(file, error.source()) + std::string(error.description()));
  }
  SceneConfig config;
  const Keys keys = keys_of(config.surface_light_field);
  for (const auto& [section, content] : document) {
    if (section == "rung") {
      config.ladder = ladder_of(content, file);
      continue;
    }
    if (section != "surface_light_field" || !content.is_table())
      throw ConfigError(place(file, content.source()) + "unknown section [" + std::string(section.str()) +
                        "]; a scene has [surface_light_field] and, from `tradeoff`, [[rung]]");
    for (const auto& [key, value] : *content.as_table()) {
      const auto known = keys.find(key.str());
      if (known == keys.end())
        throw ConfigError(place(file, value.source()) + "unknown key " + std::string(key.str()) + "; [" +
                          std::string(section.str()) + "] has " + key_list(keys));
      if (const std::string demand = known->second.set(value); !demand.empty())
        throw ConfigError(place(file, value.source()) + std::string(key.str()) + " " + demand);
    }
  }
  try {
    require_valid(config.surface_light_field);
  } catch (const ConfigError& error) {
    throw ConfigError(place_of_rule(file, document, error.what()) + error.what());
  }
  return config;
}

std::string to_toml(const SurfaceLightFieldOptions& options) {
  SurfaceLightFieldOptions copy = options;
  std::string text = "[surface_light_field]\n";
  for (const auto& [name, key] : keys_of(copy)) text += name + " = " + key.text() + '\n';
  return text;
}

std::string rungs_to_toml(const MeasuredLadder& ladder) {
  std::string text;
  for (const MeasuredRung& rung : ladder) {
    char entry[96];
    std::snprintf(entry, sizeof entry, "[[rung]]\nimage_ms = %.9g\npsnr_db = %.9g\n", rung.image_ms, rung.psnr_db);
    text += entry;
  }
  return text;
}

}  // namespace sheen
