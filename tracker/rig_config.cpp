// SPDX-License-Identifier: Apache-2.0
#include "tracker/rig_config.h"

#include <toml++/toml.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "common/base/errors.h"
#include "common/camera/camera_file.h"
#include "common/link/endpoint.h"

namespace sheen {
namespace {

/// Takes the value of a key; returns what is wrong with it, or nothing.
using Setter = std::function<std::string(const toml::node&)>;
using Section = std::map<std::string, Setter, std::less<>>;

Setter number(double& target) {
  return [&target](const toml::node& node) -> std::string {
    const auto value = node.value<double>();  // an integer will do
    if (!value || !std::isfinite(*value)) return "must be a number";
    target = *value;
    return {};
  };
}

Setter integer(int& target) {
  return [&target](const toml::node& node) -> std::string {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || *value < 0 || *value > std::numeric_limits<int>::max()) return "must be a whole number, 0 or more";
    target = static_cast<int>(*value);
    return {};
  };
}

Setter text(std::function<void(const std::string&)> take) {
  return [take = std::move(take)](const toml::node& node) -> std::string {
    const auto value = node.value_exact<std::string>();
    if (!value || value->empty()) return "must be a text in quotes";
    take(*value);
    return {};
  };
}

Setter whole_number(std::function<void(int)> take) {
  return [take = std::move(take)](const toml::node& node) -> std::string {
    int value = 0;
    std::string wrong = integer(value)(node);
    if (wrong.empty()) take(value);
    return wrong;
  };
}

std::string take_flag(const toml::node& node, bool& target) {
  const auto value = node.value_exact<bool>();
  if (!value) return "must be true or false";
  target = *value;
  return {};
}

std::string take_vector(const toml::node& node, Eigen::Vector3d& target) {
  const toml::array* values = node.as_array();
  if (!values || values->size() != 3) return "must be a list of 3 numbers, metres";
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = (*values)[i].value<double>();
    if (!value || !std::isfinite(*value)) return "must hold numbers only";
    target[static_cast<Eigen::Index>(i)] = *value;
  }
  return {};
}

std::string take_lens(const toml::node& node, Camera& camera) {
  const auto value = node.value_exact<std::string>();
  if (value == "opencv")
    camera.lens = LensModel::kOpenCv;
  else if (value == "fisheye")
    camera.lens = LensModel::kFisheye;
  else
    return "must be \"opencv\" or \"fisheye\"";
  return {};
}

std::string take_distortion(const toml::node& node, Camera& camera) {
  const toml::array* values = node.as_array();
  if (!values || values->size() > camera.distortion.size()) return "must be a list of up to 5 numbers";
  for (std::size_t i = 0; i < values->size(); ++i) {
    const auto value = (*values)[i].value<double>();
    if (!value || !std::isfinite(*value)) return "must hold numbers only";
    camera.distortion[i] = *value;
  }
  return {};
}

std::string take_gains(const toml::node& node, std::array<double, 3>& gains) {
  const toml::array* values = node.as_array();
  if (!values || values->size() != gains.size()) return "must be a list of 3 numbers: red, green, blue";
  for (std::size_t i = 0; i < gains.size(); ++i) {
    const auto value = (*values)[i].value<double>();
    if (!value || !(*value > 0) || !std::isfinite(*value)) return "must hold numbers above 0 only";
    gains[i] = *value;
  }
  return {};
}

std::string place(const std::filesystem::path& file, const toml::source_region& source) {
  return file.string() + ":" + std::to_string(source.begin.line) + ": ";
}

toml::table parse(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file)) throw FileError(file.string(), "does not exist or is not a file");
  try {
    return toml::parse_file(file.string());
  } catch (const toml::parse_error& error) {
    throw ConfigError(place(file, error.source()) + std::string(error.description()));
  }
}

std::string key_list(const Section& section) {
  std::string list;
  for (const auto& [key, setter] : section) list += (list.empty() ? "" : ", ") + key;
  return list;
}

void read_section(const std::filesystem::path& file, const std::string& name, const toml::table& table,
                  const Section& section) {
  for (const auto& [key, value] : table) {
    const auto setter = section.find(key.str());
    const std::string where = place(file, value.source()) + name + "." + std::string(key.str());
    if (setter == section.end()) throw ConfigError(where + " is unknown; [" + name + "] has " + key_list(section));
    const std::string wrong = setter->second(value);
    if (!wrong.empty()) throw ConfigError(where + " " + wrong);
  }
}

}  // namespace

RigConfig load_rig_config(const std::filesystem::path& file) {
  const toml::table document = parse(file);
  RigConfig config;
  Camera camera;
  std::filesystem::path camera_file;
  GateOptions& gate = config.gate;
  LightOptions light;
  const auto path = [&](const std::string& name) { return file.parent_path() / name; };
  const std::map<std::string, Section, std::less<>> sections{
      {"camera",
       {{"file", text([&](const std::string& v) { camera_file = path(v); })},
        {"width", integer(camera.width)},
        {"height", integer(camera.height)},
        {"fx", number(camera.fx)},
        {"fy", number(camera.fy)},
        {"cx", number(camera.cx)},
        {"cy", number(camera.cy)},
        {"lens", [&](const toml::node& node) { return take_lens(node, camera); }},
        {"distortion", [&](const toml::node& node) { return take_distortion(node, camera); }},
        {"still", [&](const toml::node& node) { return take_flag(node, config.still_camera); }}}},
      {"light",
       {{"table", text([&](const std::string& v) { light.table = path(v); })},
        {"index", text([&](const std::string& v) { light.index = path(v); })},
        {"first_frame", whole_number([&](int v) { light.first_frame = static_cast<std::uint64_t>(v); })},
        {"tag", whole_number([&](int v) { light.tag = v; })},
        {"tag_size_m", number(light.tag_size_m)},
        {"offset", [&](const toml::node& node) { return take_vector(node, light.offset); }}}},
      {"stage", {{"file", text([&](const std::string& v) { config.stage_file = path(v); })}}},
      {"source",
       {{"uri", text([&](const std::string& v) { config.source_uri = v; })},
        {"frame_rate_hz", number(config.source.frame_rate_hz)},
        {"exposure_us", number(config.source.exposure_us)},
        {"gain_db", number(config.source.gain_db)},
        {"black_level", number(config.source.black_level)},
        {"white_balance", [&](const toml::node& node) { return take_gains(node, config.source.white_balance); }},
        {"pixel_format", text([&](const std::string& v) { config.source.pixel_format = v; })}}},
      {"link",
       {{"endpoint",
         [&](const toml::node& node) -> std::string {
           config.endpoint = node.value<std::string>().value_or("");
           return endpoint_error(config.endpoint);
         }},
        {"keys", text([&](const std::string& v) { config.keys = path(v); })},
        {"allow", text([&](const std::string& v) { config.allow = path(v); })}}},
      {"gate",
       {{"min_tags", integer(gate.min_tags)},
        {"max_blur_px", number(gate.max_blur_px)},
        {"max_overexposed", number(gate.max_overexposed)},
        {"min_bright", number(gate.min_bright)},
        {"min_angle_deg", number(gate.min_angle_deg)},
        {"min_distance_m", number(gate.min_distance_m)},
        {"max_uncertainty_px", number(gate.max_uncertainty_px)}}},
  };
  for (const auto& [name, content] : document) {
    const auto section = sections.find(name.str());
    if (section == sections.end() || !content.is_table())
      throw ConfigError(place(file, content.source()) + "unknown section [" + std::string(name.str()) +
                        "]; a rig has [camera], [stage], [light], [source], [link], [gate]");
    read_section(file, section->first, *content.as_table(), section->second);
  }
  if (const toml::table* given = document["camera"].as_table()) {
    if (!camera_file.empty()) {
      if (given->size() > (given->contains("still") ? 2 : 1))
        throw ConfigError(place(file, given->source()) +
                          "camera.file stands beside other keys of [camera]; the file has them all");
      const CameraFile calibrated = load_camera(camera_file);
      camera = calibrated.camera;
      if (calibrated.photometric) config.photometry = calibrated.photometric->photometry;
    } else {
      for (const char* key : {"width", "height", "fx", "fy", "cx", "cy"})
        if (!given->contains(key))
          throw ConfigError(place(file, given->source()) + "camera." + key +
                            " is missing; give it, or `file` with what `sheen-tracker calibrate` wrote");
    }
    const std::string wrong = validation_error(camera);
    if (!wrong.empty()) throw ConfigError(place(file, given->source()) + wrong);
    config.camera = camera;
    config.source.width = camera.width;
    config.source.height = camera.height;
  }
  if (const toml::table* given = document["light"].as_table()) {
    const std::string wrong = validation_error(light);
    if (!wrong.empty()) throw ConfigError(place(file, given->source()) + "light." + wrong);
    config.light = light;
  }
  const std::string wrong = validation_error(gate);
  if (!wrong.empty()) throw ConfigError(file.string() + ": gate." + wrong);
  const auto require = [&](bool holds, const char* rule) {
    if (!holds) throw ConfigError(file.string() + ": source." + rule);
  };
  const SourceSettings& source = config.source;
  require(source.frame_rate_hz == 0 || (source.frame_rate_hz >= 0.001 && source.frame_rate_hz <= 10'000),
          "frame_rate_hz must be 0 (the camera's) or 0.001..10000");
  require(source.exposure_us == 0 || (source.exposure_us >= 1 && source.exposure_us <= 60e6),
          "exposure_us must be 0 (the camera's) or 1..60000000");
  require(source.gain_db <= 100, "gain_db must be 100 at most");
  require(source.pixel_format.empty() || (pixel_format_from_pfnc(source.pixel_format) != PixelFormat::kUnspecified &&
                                          source.pixel_format != "RGB32f"),
          "pixel_format must be BayerRG8, BayerGR8, BayerGB8, BayerBG8, RGB8 or Mono8");
  return config;
}

}  // namespace sheen
