// SPDX-License-Identifier: Apache-2.0
#include "tests/architecture/include_rules.h"

#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>

namespace sheen {
namespace {

/// A file whose path matches `files` may include what matches `allowed` (in which $1 is what `files` captured), and
/// nothing else of what matches `forbidden`. All match whole strings.
struct Rule {
  std::string says;
  std::string files;
  std::string forbidden;
  std::string allowed;
};

const std::string kSources = "(?:common|tracker|reconstructor)/.*";
const std::string kHeavy =
    "opencv2/.*|embree3/.*|.*\\.pb\\.h|google/protobuf/.*|zmq.*|httplib\\.h|sqlite3\\.h|arv\\.h|spdlog/.*|"
    "nlohmann/json\\.hpp|toml\\+\\+/.*|CLI/.*|Imf.*|GLFW/.*|imgui.*|backends/.*|epoxy/.*|ceres/.*|tbb/"
    ".*|png\\.h|jpeglib\\.h|zstd\\.h|"
    "sodium\\.h|apriltag/.*|pybind11/.*";

/// The rooms of a house, a floor each: a file includes what stands in its own room and in those named after it.
struct Room {
  std::string room, stands_on;
};
const std::vector<Room> kCommon = {
    {"base", ""},
    {"parallel", ""},
    {"http", "base"},
    {"plot", "base"},
    {"geometry", "base"},
    {"stage", "base"},
    {"image", "base"},
    {"camera", "base|image"},
    {"capture", "base|image|camera"},
    {"link", "base|image|camera|capture"},
    {"registration", "base|image|camera|capture|geometry"},
    {"session", "base|image|camera|capture|link"},
    {"datasets", "base|image|camera|capture"},
    {"simulation", "base|image|camera|capture|geometry|stage|datasets"},
};
const std::vector<Room> kReconstructor = {
    {"coding", ""},
    {"numerics", ""},
    {"surface", "numerics"},
    {"radiance", "surface|numerics"},
    {"refinement", ""},
    {"shape", "refinement|radiance|surface|numerics"},
    {"light_field_file", "radiance|surface|numerics|coding"},
    {"irradiance_field_file", "radiance|numerics|coding"},
    {"lumigraph_file", "radiance|numerics|coding"},
    {"models", "light_field_file|irradiance_field_file|lumigraph_file|radiance|surface|numerics|coding"},
    {"render", "models|surface|numerics"},
    {"page", "light_field_file|irradiance_field_file|radiance|surface|numerics|coding"},
    {"exchange", "models"},
    {"splats", "render|models|numerics"},
    {"library", "light_field_file"},
    {"monitor", ""},
    {"evaluation", "render|models|radiance|surface|numerics"},
    {"effort", "evaluation|render|models|radiance"},
    {"scene", "effort|models"},
    {"capture", "scene|effort|evaluation|monitor|page|render|models|radiance|shape|refinement"},
    {"studies", "lumigraph_file|effort|evaluation|render|models|radiance|surface|numerics"},
};

std::vector<Rule> rules_of_rooms(const std::string& house, const std::vector<Room>& rooms) {
  std::vector<Rule> rules;
  for (const auto& [room, stands_on] : rooms) {
    const std::string own = room + (stands_on.empty() ? "" : "|" + stands_on);
    rules.push_back({house + "/" + room + " stands on " + (stands_on.empty() ? "no other room" : stands_on),
                     house + "/" + room + "/.*", house + "/.*", house + "/(" + own + ")/.*"});
  }
  return rules;
}

std::vector<Rule> all_rules() {
  std::vector<Rule> all = {
      {"common knows neither daemon", "common/.*", "(tracker|reconstructor)/.*", ""},
      {"the daemons meet on the wire only", "tracker/.*", "reconstructor/.*", ""},
      {"the daemons meet on the wire only", "reconstructor/.*", "tracker/.*", ""},
      {"sources never include tests", kSources, "tests/.*", ""},
      {"numerics sees Eigen and the standard library only", "reconstructor/numerics/.*", ".*",
       "reconstructor/numerics/.*|Eigen/.*|[a-z0-9_]+"},
      {"a file is decoded without threads, rays, pictures and the encoder", "reconstructor/light_field_file/[^/]*",
       "reconstructor/light_field_file/encode/.*|tbb/.*|thread|future|common/(image|geometry/(?!mesh\\.h)).*", ""},
      {"so are those of models that are relit, into pictures of plain pixels",
       "reconstructor/(?:irradiance_field_file|lumigraph_file)/[^/]*",
       ".*/encode/.*|tbb/.*|thread|future|opencv2/.*|common/(image/(?!(?:image|color)\\.h)|geometry/).*", ""},
      {"other programs read our header with the standard library alone", "reconstructor/library/sheen/.*", ".*",
       "[a-z0-9_]+"},
      {"models never include each other", "reconstructor/models/([^/]+)/.*", "reconstructor/models/[^/]+/.*",
       "reconstructor/models/$1/.*"},
      {"what all models share knows none of them", "reconstructor/models/[^/]+", "reconstructor/models/[^/]+/.*", ""},
      {"a model is named in its own folder, by the registry and by studies of it",
       "reconstructor/(?!models/|studies/|commands/(tradeoff|figures|study_options)\\.).*",
       "reconstructor/models/[^/]+/.*", ""},
      {"only main and the Python module include commands", "(tracker|reconstructor)/(?!commands/|python/|main\\.cpp).*",
       "(tracker|reconstructor)/commands/.*", ""},
      {"only the wire reads Protobuf messages", kSources + "|tests/.*", ".*\\.pb\\.h", ""},
      {"only the transport uses ZeroMQ", kSources, "zmq.*", ""},
      {"only bundle.cpp uses Ceres", kSources + "|tests/.*", "ceres/.*", ""},
      {"only the Python module uses pybind11", kSources + "|tests/.*", "pybind11/.*", ""},
      {"only ray_scene.cpp uses Embree", kSources + "|tests/.*", "embree3/.*", ""},
      {"only command_line.cpp uses CLI11", kSources + "|tests/.*", "CLI/.*", ""},
      {"heavy third-party headers stay out of our headers", kSources + "\\.h", kHeavy, ""},
      {"what carries a third-party header is for .cpp files", kSources + "\\.h",
       "common/(base/json_(fields|number)|link/proto_io)\\.h", ""},
  };
  for (const auto& [house, rooms] : {std::pair{"common", kCommon}, std::pair{"reconstructor", kReconstructor}}) {
    const std::vector<Rule> more = rules_of_rooms(house, rooms);
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

const std::vector<Rule>& rules() {
  static const std::vector<Rule> all = all_rules();
  return all;
}

/// The few files that a rule is about.
struct Exception {
  std::string files;
  std::string allowed;
};
const std::vector<Exception>& exceptions() {
  static const std::vector<Exception> all = {
      {"common/link/(wire[a-z_]*|monitor_socket)\\.cpp|tests/common/link/wire[a-z_]*\\.cpp", "proto/.*\\.pb\\.h"},
      {"common/link/proto_io\\.h", "google/protobuf/.*"},
      {"common/base/json_(fields|number)\\.h", "nlohmann/json\\.hpp"},
      {"common/link/(transport[a-z_]*|link_sockets|capture_sender|capture_receiver|monitor_socket|curve_keys)\\.cpp",
       "zmq.*"},
      {"reconstructor/python/[^/]*\\.cpp", "pybind11/.*"},
      {"common/geometry/ray_scene\\.cpp", "embree3/.*"},
      {"common/base/command_line\\.cpp", "CLI/.*"},
      {"tracker/calibration/bundle\\.cpp", "ceres/.*"},
      {"reconstructor/models/[a-z_]+/gl/.*", "reconstructor/render/.*"},  // how the window draws a model
      {"reconstructor/models/model_registry\\.cpp", "reconstructor/models/[a-z_]+/kind\\.h"},
  };
  return all;
}

bool excepted(const Include& include) {
  for (const Exception& exception : exceptions()) {
    if (std::regex_match(include.file, std::regex(exception.files)) &&
        std::regex_match(include.target, std::regex(exception.allowed)))
      return true;
  }
  return false;
}

bool breaks(const Include& include, const Rule& rule) {
  std::smatch match;
  if (!std::regex_match(include.file, match, std::regex(rule.files))) return false;
  if (!std::regex_match(include.target, std::regex(rule.forbidden))) return false;
  return rule.allowed.empty() || !std::regex_match(include.target, std::regex(match.format(rule.allowed)));
}

}  // namespace

std::vector<Include> includes_of(const std::string& file, const std::string& text) {
  static const std::regex directive("\\s*#\\s*include\\s*[<\"]([^>\"]+)[>\"].*");
  std::vector<Include> includes;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::smatch match;
    if (std::regex_match(line, match, directive)) includes.push_back({file, number, match[1]});
  }
  return includes;
}

std::vector<Include> includes_below(const std::filesystem::path& root) {
  namespace fs = std::filesystem;
  std::vector<Include> all;
  for (const char* folder : {"common", "tracker", "reconstructor", "tests"}) {
    if (!fs::exists(root / folder)) continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      const fs::path& path = entry.path();
      if (!entry.is_regular_file() || (path.extension() != ".h" && path.extension() != ".cpp")) continue;
      std::ifstream stream(path);
      const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
      const std::vector<Include> found = includes_of(fs::relative(path, root).generic_string(), text);
      all.insert(all.end(), found.begin(), found.end());
    }
  }
  return all;
}

std::vector<std::string> broken_include_rules(const std::vector<Include>& includes) {
  std::vector<std::string> broken;
  for (const Include& include : includes) {
    if (excepted(include)) continue;
    for (const Rule& rule : rules()) {
      if (breaks(include, rule))
        broken.push_back(include.file + ":" + std::to_string(include.line) + " includes " + include.target + ": " +
                         rule.says);
    }
  }
  return broken;
}

}  // namespace sheen
