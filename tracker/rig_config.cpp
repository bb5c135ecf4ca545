// SPDX-License-Identifier: Apache-2.0
#include "tracker/rig_config.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string_view>

#include "common/base/errors.h"
#include "common/camera/camera_file.h"
#include "common/link/endpoint.h"
#include "tracker/sources/stream_address.h"

namespace sheen {
namespace {

/// Takes the value of a key; returns what is wrong with it, or nothing.
using Setter = std::function<std::string(const toml::node&)>;
using Section = std::map<std::string, Setter, std::less<>>;
using Sections = std::map<std::string, Section, std::less<>>;

constexpr std::size_t kMaxNameLength = 32;
constexpr const char* kCameras = "cameras";

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

/// What is read of a camera before it is known to be whole.
struct CameraDraft {
  Camera camera;
  std::filesystem::path camera_file;
  LightOptions light;
};

/// The sections that one camera has.
Sections sections_of(const std::filesystem::path& folder, CameraDraft& draft, CameraConfig& config) {
  Camera& camera = draft.camera;
  LightOptions& light = draft.light;
  SourceSettings& source = config.source;
  GateOptions& gate = config.gate;
  const auto path = [folder](std::filesystem::path& target) {
    return text([folder, &target](const std::string& v) { target = folder / v; });
  };
  return {{"camera",
           {{"file", path(draft.camera_file)},
            {"width", integer(camera.width)},
            {"height", integer(camera.height)},
            {"fx", number(camera.fx)},
            {"fy", number(camera.fy)},
            {"cx", number(camera.cx)},
            {"cy", number(camera.cy)},
            {"lens", [&camera](const toml::node& node) { return take_lens(node, camera); }},
            {"distortion", [&camera](const toml::node& node) { return take_distortion(node, camera); }},
            {"still", [&config](const toml::node& node) { return take_flag(node, config.still); }}}},
          {"light",
           {{"table", path(light.table)},
            {"index", path(light.index)},
            {"first_frame", whole_number([&light](int v) { light.first_frame = static_cast<std::uint64_t>(v); })},
            {"tag", whole_number([&light](int v) { light.tag = v; })},
            {"tag_size_m", number(light.tag_size_m)},
            {"offset", [&light](const toml::node& node) { return take_vector(node, light.offset); }}}},
          {"source",
           {{"uri", text([&config](const std::string& v) { config.source_uri = v; })},
            {"frame_rate_hz", number(source.frame_rate_hz)},
            {"exposure_us", number(source.exposure_us)},
            {"gain_db", number(source.gain_db)},
            {"black_level", number(source.black_level)},
            {"white_balance", [&source](const toml::node& node) { return take_gains(node, source.white_balance); }},
            {"pixel_format", text([&source](const std::string& v) { source.pixel_format = v; })}}},
          {"gate",
           {{"min_tags", integer(gate.min_tags)},
            {"max_blur_px", number(gate.max_blur_px)},
            {"max_overexposed", number(gate.max_overexposed)},
            {"min_bright", number(gate.min_bright)},
            {"min_angle_deg", number(gate.min_angle_deg)},
            {"min_distance_m", number(gate.min_distance_m)},
            {"max_uncertainty_px", number(gate.max_uncertainty_px)}}}};
}

/// The camera's numbers, from its file or from `given`, [camera] itself.
void take_camera(const std::filesystem::path& file, const toml::table& given, CameraDraft draft, CameraConfig& config) {
  if (!draft.camera_file.empty()) {
    if (given.size() > (given.contains("still") ? 2 : 1))
      throw ConfigError(place(file, given.source()) +
                        "camera.file stands beside other keys of [camera]; the file has them all");
    const CameraFile calibrated = load_camera(draft.camera_file);
    draft.camera = calibrated.camera;
    if (calibrated.photometric) config.photometry = calibrated.photometric->photometry;
  } else {
    for (const char* key : {"width", "height", "fx", "fy", "cx", "cy"})
      if (!given.contains(key))
        throw ConfigError(place(file, given.source()) + "camera." + key +
                          " is missing; give it, or `file` with what `sheen-tracker calibrate` wrote");
  }
  const std::string wrong = validation_error(draft.camera);
  if (!wrong.empty()) throw ConfigError(place(file, given.source()) + wrong);
  config.camera = draft.camera;
  config.source.width = draft.camera.width;
  config.source.height = draft.camera.height;
}

void check_source(const std::string& where, const SourceSettings& source) {
  const auto require = [&](bool holds, const char* rule) {
    if (!holds) throw ConfigError(where + "source." + rule);
  };
  require(source.frame_rate_hz == 0 || (source.frame_rate_hz >= 0.001 && source.frame_rate_hz <= 10'000),
          "frame_rate_hz must be 0 (the camera's) or 0.001..10000");
  require(source.exposure_us == 0 || (source.exposure_us >= 1 && source.exposure_us <= 60e6),
          "exposure_us must be 0 (the camera's) or 1..60000000");
  require(source.gain_db <= 100, "gain_db must be 100 at most");
  require(source.pixel_format.empty() || (pixel_format_from_pfnc(source.pixel_format) != PixelFormat::kUnspecified &&
                                          source.pixel_format != "RGB32f"),
          "pixel_format must be BayerRG8, BayerGR8, BayerGB8, BayerBG8, RGB8 or Mono8");
}

/// Reads what `table` says of a camera over what `config` holds already. `others`: the sections it has besides.
/// `plain_key`: the one key that is no section.
void read_camera(const std::filesystem::path& file, const toml::table& table, const Sections& others,
                 std::string_view plain_key, CameraConfig& config) {
  CameraDraft draft;
  if (config.light) draft.light = *config.light;
  Sections sections = sections_of(file.parent_path(), draft, config);
  sections.insert(others.begin(), others.end());
  std::string list;
  for (const auto& [name, section] : sections) list += (list.empty() ? "[" : ", [") + name + "]";
  for (const auto& [name, content] : table) {
    if (name.str() == plain_key) continue;
    const auto section = sections.find(name.str());
    if (section == sections.end() || !content.is_table())
      throw ConfigError(place(file, content.source()) + "unknown section [" + std::string(name.str()) + "]; " +
                        (others.empty() ? "an entry of [[cameras]] has name, and " + list
                                        : "a rig has " + list + "; several cameras have [[cameras]]"));
    read_section(file, section->first, *content.as_table(), section->second);
  }
  if (const toml::table* given = table["camera"].as_table()) take_camera(file, *given, draft, config);
  if (const toml::table* given = table["light"].as_table()) {
    const std::string wrong = validation_error(draft.light);
    if (!wrong.empty()) throw ConfigError(place(file, given->source()) + "light." + wrong);
    config.light = draft.light;
  }
  const std::string where = file.string() + ": " + (config.name.empty() ? "" : "camera " + config.name + ": ");
  const std::string wrong = validation_error(config.gate);
  if (!wrong.empty()) throw ConfigError(where + "gate." + wrong);
  check_source(where, config.source);
}

bool is_camera_name(const std::string& name) {
  return !name.empty() && name.size() <= kMaxNameLength &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) || c == '-' || c == '_'; });
}

/// An entry of [[cameras]]; `common` is what holds for all of them.
CameraConfig read_entry(const std::filesystem::path& file, const toml::table& entry, const CameraConfig& common) {
  const std::string where = place(file, entry.source());
  CameraConfig config = common;
  config.name = entry["name"].value_exact<std::string>().value_or("");
  if (!is_camera_name(config.name))
    throw ConfigError(where + "an entry of [[cameras]] needs a name of up to " + std::to_string(kMaxNameLength) +
                      " letters, digits, - and _");
  read_camera(file, entry, {}, "name", config);
  if (!config.camera) throw ConfigError(where + "camera " + config.name + ": camera.file is missing");
  if (!config.source_uri) throw ConfigError(where + "camera " + config.name + ": source.uri is missing");
  return config;
}

std::vector<CameraConfig> read_entries(const std::filesystem::path& file, const toml::node& node,
                                       const CameraConfig& common) {
  const toml::array* entries = node.as_array();
  if (!entries || entries->empty() || !entries->is_homogeneous(toml::node_type::table))
    throw ConfigError(place(file, node.source()) + "cameras must be [[cameras]], an entry for each camera");
  std::vector<CameraConfig> cameras;
  for (const toml::node& entry : *entries) {
    CameraConfig config = read_entry(file, *entry.as_table(), common);
    for (const CameraConfig& other : cameras) {
      if (other.name == config.name)
        throw ConfigError(place(file, entry.source()) + "two cameras have the name " + config.name);
      if (other.source_uri == config.source_uri)
        throw ConfigError(place(file, entry.source()) + "cameras " + other.name + " and " + config.name +
                          " have the same source.uri, " + without_password(*config.source_uri));
    }
    cameras.push_back(std::move(config));
  }
  return cameras;
}

}  // namespace

RigConfig load_rig_config(const std::filesystem::path& file) {
  const toml::table document = parse(file);
  const toml::node* const several = document.get(kCameras);
  if (several && (document.contains("camera") || document["source"]["uri"]))
    throw ConfigError(place(file, several->source()) +
                      "[[cameras]] stands beside [camera] or source.uri; each camera has its own: camera.file = ..., "
                      "source.uri = ... in its entry");
  RigConfig config;
  const auto path = [&](const std::string& name) { return file.parent_path() / name; };
  const Sections common{
      {"stage", {{"file", text([&](const std::string& v) { config.stage_file = path(v); })}}},
      {"link",
       {{"endpoint",
         [&](const toml::node& node) -> std::string {
           config.endpoint = node.value<std::string>().value_or("");
           return endpoint_error(config.endpoint);
         }},
        {"keys", text([&](const std::string& v) { config.keys = path(v); })},
        {"allow", text([&](const std::string& v) { config.allow = path(v); })}}},
  };
  read_camera(file, document, common, kCameras, config.cameras.front());
  if (several) config.cameras = read_entries(file, *several, config.cameras.front());
  return config;
}

CameraConfig& camera_named(RigConfig& config, const std::string& name) {
  if (name.empty() && config.cameras.size() == 1) return config.cameras.front();
  const auto found = std::ranges::find(config.cameras, name, &CameraConfig::name);
  if (!name.empty() && found != config.cameras.end()) return *found;
  std::string names;
  for (const CameraConfig& camera : config.cameras) names += (names.empty() ? "" : ", ") + camera.name;
  throw ConfigError(name.empty() ? "the rig has several cameras: " + names + "; say which one with --camera"
                                 : "the rig has no camera named " + name +
                                       (names.empty() ? "; its only camera has no name" : "; it has " + names));
}

}  // namespace sheen
