// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/light_list.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/capture/capture_validation.h"
#include "common/image/image_io.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostImages = 4096, kMostBytes = std::size_t{1} << 22;
constexpr double kFarthest = 1e6;
constexpr double kUnitWithin = 0.02;
constexpr std::string_view kSpace = " \t\r";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

/// Takes the last word away.
std::string_view last_word(std::string_view& line) {
  line = trimmed(line);
  const std::size_t before = line.find_last_of(kSpace);
  const std::string_view word = line.substr(before == std::string_view::npos ? 0 : before + 1);
  line = trimmed(line.substr(0, line.size() - word.size()));
  return word;
}

template <typename Number>
std::optional<Number> number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// Lines that are not empty, with their numbers.
struct Line {
  int number = 0;
  std::string_view text;
};
std::vector<Line> lines_of(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  std::vector<Line> lines;
  for (int n = 1; !text.empty(); ++n) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (const std::string_view line = trimmed(text.substr(0, end)); !line.empty()) lines.push_back({n, line});
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// Directions if all are as long as one; positions if hardly any is.
void find_kind(const std::string& file, const std::vector<Line>& lines, std::vector<LitView>& views) {
  const auto is_unit = [](const LitView& view) { return std::abs(view.light.position.norm() - 1) <= kUnitWithin; };
  const auto units = static_cast<std::size_t>(std::count_if(views.begin(), views.end(), is_unit));
  if (units < views.size() && 2 * units > views.size()) {
    const std::size_t odd =
        static_cast<std::size_t>(std::find_if_not(views.begin(), views.end(), is_unit) - views.begin());
    throw FileError(file, "line " + std::to_string(lines[odd + 1].number) + ": " + views[odd].name +
                              ": most lights are directions of length 1, but this one has length " +
                              std::to_string(views[odd].light.position.norm()));
  }
  for (LitView& view : views) {
    view.light.kind = units == views.size() ? LightKind::kDirectional : LightKind::kPoint;
    if (view.light.kind == LightKind::kDirectional) view.light.position.normalize();
  }
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

fs::path image_of(const fs::path& list, const std::string& name) {
  const fs::path folder = list.parent_path();
  const std::string last = name.substr(name.find_last_of("/\\") + 1);
  for (const fs::path& path : {folder / name, folder / last})
    if (is_file(path)) return path;
  throw FileError(list.string(), "names " + name + ", but there is no such image beside it");
}

/// A pinhole that looks straight at the origin.
PosedCamera standing_camera(const ImageSize& size) {
  PosedCamera posed;
  const double focal = std::max(size.width, size.height);
  posed.camera = {.width = size.width,
                  .height = size.height,
                  .fx = focal,
                  .fy = focal,
                  .cx = (size.width - 1) / 2.0,
                  .cy = (size.height - 1) / 2.0};
  posed.camera_from_object.rotation =
      Eigen::Quaterniond(0, 1, 0, 0);  // y up and z towards the eye become down and away
  posed.camera_from_object.translation = {0, 0, 1};
  return posed;
}

}  // namespace

std::vector<LitView> parse_light_list(const std::string& file, std::string_view text) {
  const auto fail = [&](const Line& line, const std::string& what) {
    throw FileError(file, "line " + std::to_string(line.number) + ": " + what);
  };
  const std::vector<Line> lines = lines_of(text);
  const auto count = lines.empty() ? std::nullopt : number<std::size_t>(lines[0].text);
  if (!count || *count == 0 || *count > kMostImages)
    throw FileError(file,
                    "must begin with a line that says how many images follow, 1 to " + std::to_string(kMostImages));
  if (lines.size() - 1 != *count)
    throw FileError(file, "says that " + std::to_string(*count) + " images follow, but has lines for " +
                              std::to_string(lines.size() - 1));
  std::vector<LitView> views;
  std::set<std::string_view> names;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    LitView view;
    std::string_view rest = lines[i].text;
    for (const int axis : {2, 1, 0}) {
      const auto value = number<double>(last_word(rest));
      if (!value || !(std::abs(*value) <= kFarthest)) fail(lines[i], "must be a name and three numbers, x y z");
      view.light.position[axis] = *value;
    }
    view.name = rest;
    if (rest.empty() || !is_plain_text(view.name)) fail(lines[i], "must begin with the name of an image");
    if (!names.insert(rest).second) fail(lines[i], view.name + " stands there twice");
    if (!(view.light.position.norm() > 1e-9)) fail(lines[i], view.name + ": a light at 0 0 0 has no direction");
    views.push_back(std::move(view));
  }
  find_kind(file, lines, views);
  return views;
}

std::vector<LitView> load_lights(const fs::path& list) {
  return parse_light_list(list.string(), read_file(list, kMostBytes));
}

LightList load_light_list(const fs::path& list) {
  const std::string text = read_file(list, kMostBytes);
  LightList lights{.views = parse_light_list(list.string(), text)};
  ImageSize first;
  std::string bytes = content_hash(text);
  for (const LitView& view : lights.views) {
    const fs::path image = image_of(list, view.name);
    const ImageSize size = read_image_size(image);
    if (lights.images.empty()) first = size;
    if (size.width != first.width || size.height != first.height)
      throw FileError(image.string(), "is " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                                          " pixels, but " + lights.images.front().string() + " is " +
                                          std::to_string(first.width) + " x " + std::to_string(first.height) +
                                          ": all images of a list are of one camera that stands still");
    bytes += content_hash(read_file(image));
    lights.images.push_back(image);
  }
  lights.camera = standing_camera(first);
  lights.hash = content_hash(bytes);
  return lights;
}

Capture read_capture(const LightList& list, std::size_t index) {
  Capture capture;
  capture.source_session = "lights:" + list.hash;
  capture.sequence = index + 1;
  capture.camera_frame_id = index;
  capture.name = list.views.at(index).name;
  capture.camera = list.camera.camera;
  capture.image = read_image(list.images.at(index));
  if (capture.image.width != capture.camera.width || capture.image.height != capture.camera.height)
    throw FileError(list.images[index].string(), "has changed its size");
  capture.mask = ImageU8(capture.camera.width, capture.camera.height, 1, 255);
  capture.pose.status = PoseStatus::kGiven;
  capture.pose.camera_from_object = list.camera.camera_from_object;
  capture.light = list.views[index].light;
  capture.verdict = FrameVerdict::kKeyframe;
  return capture;
}

}  // namespace sheen
