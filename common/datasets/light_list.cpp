// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/light_list.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/length_limit.h"
#include "common/capture/capture_validation.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostImages = 4096;
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

/// As programs of any country write it: "0,5" is a half, too.
template <typename Number>
std::optional<Number> number(std::string_view written) {
  std::string word(written.substr(written.starts_with('+') ? 1 : 0));
  std::replace(word.begin(), word.end(), ',', '.');
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// A name without the quotes round it, one on each side.
std::string_view unquoted(std::string_view name) {
  for (const char quote : {'"', '\''})
    if (name.size() > 2 && name.front() == quote && name.back() == quote)
      return trimmed(name.substr(1, name.size() - 2));
  return name;
}

/// The shortest text that reads back as the same number.
std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
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

/// The first line: how many lights follow and, if it says so, what they are.
struct Heading {
  std::size_t count = 0;
  std::optional<LightKind> kind;
};
Heading parse_heading(const std::string& file, const std::vector<Line>& lines) {
  Heading heading;
  std::string_view rest = lines.empty() ? std::string_view() : lines[0].text;
  if (rest.find_first_of(kSpace) != std::string_view::npos) {
    const std::string_view word = last_word(rest);
    if (word == "directions") heading.kind = LightKind::kDirectional;
    if (word == "positions") heading.kind = LightKind::kPoint;
    if (!heading.kind) rest = {};
  }
  heading.count = number<std::size_t>(rest).value_or(0);
  if (heading.count == 0 || heading.count > kMostImages)
    throw FileError(file, "must begin with a line that says how many images follow, 1 to " +
                              std::to_string(kMostImages) +
                              ", and may say what they are: \"49\", \"49 directions\" or "
                              "\"49 positions\"");
  return heading;
}

bool is_unit(const LitView& view) {
  return std::abs(view.light.position.norm() - 1) <= kUnitWithin;
}
bool most_are_units(std::span<const LitView> views) {
  return 2 * std::count_if(views.begin(), views.end(), is_unit) > std::ssize(views);
}

/// By their lengths: directions if all are as long as one; positions if hardly any is.
LightKind likely_kind(const std::string& file, const std::vector<Line>& lines, const std::vector<LitView>& views) {
  if (!most_are_units(views)) return LightKind::kPoint;
  const auto odd = std::find_if_not(views.begin(), views.end(), is_unit);
  if (odd == views.end()) return LightKind::kDirectional;
  const std::string count = std::to_string(views.size());
  throw FileError(file, "line " + std::to_string(lines[static_cast<std::size_t>(odd - views.begin()) + 1].number) +
                            ": " + odd->name + ": most lights are directions of length 1, but this one has length " +
                            std::to_string(odd->light.position.norm()) +
                            "; correct it, or let the first line say what they are: \"" + count +
                            " directions\" or \"" + count + " positions\"");
}

}  // namespace

std::vector<LitView> parse_light_list(const std::string& file, std::string_view text) {
  const auto fail = [&](const Line& line, const std::string& what) {
    throw FileError(file, "line " + std::to_string(line.number) + ": " + what);
  };
  const std::vector<Line> lines = lines_of(text);
  const Heading heading = parse_heading(file, lines);
  if (lines.size() - 1 != heading.count)
    throw FileError(file, "says that " + std::to_string(heading.count) + " images follow, but has lines for " +
                              std::to_string(lines.size() - 1));
  std::vector<LitView> views;
  std::set<std::string_view> names;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    LitView view;
    std::string_view rest = lines[i].text;
    for (const int axis : {2, 1, 0}) {
      const auto value = number<double>(last_word(rest));
      if (!value || !(std::abs(*value) <= kLongestLength)) fail(lines[i], "must be a name and three numbers, x y z");
      view.light.position[axis] = *value;
    }
    rest = unquoted(rest);
    view.name = rest;
    if (rest.empty() || !is_plain_text(view.name)) fail(lines[i], "must begin with the name of an image");
    if (!names.insert(rest).second) fail(lines[i], view.name + " stands there twice");
    if (!(view.light.position.norm() > 1e-9)) fail(lines[i], view.name + ": a light at 0 0 0 has no direction");
    views.push_back(std::move(view));
  }
  const LightKind kind = heading.kind ? *heading.kind : likely_kind(file, lines, views);
  for (LitView& view : views) {
    view.light.kind = kind;
    if (kind == LightKind::kDirectional) view.light.position.normalize();
  }
  return views;
}

std::string light_list_text(std::span<const LitView> views) {
  std::string text = std::to_string(views.size());
  if (views.front().light.kind == LightKind::kPoint && most_are_units(views)) text += " positions";
  text += '\n';
  for (const LitView& view : views) {
    text += unquoted(view.name) == view.name ? view.name : '"' + view.name + '"';
    for (const double value : view.light.position) text += ' ' + shortest(value);
    text += '\n';
  }
  return text;
}

std::string assumption_about(const std::string& file, std::string_view text, std::span<const LitView> views) {
  if (parse_heading(file, lines_of(text)).kind) return {};
  const std::string count = std::to_string(views.size());
  const auto may_say = [&](const char* kind) { return "let the first line say \"" + count + " " + kind + "\""; };
  if (views.front().light.kind == LightKind::kDirectional)
    return file + ": " + count +
           " lights of length 1 are taken for directions of far lights; if they are places on a " +
           "dome of 1 m radius, " + may_say("positions");
  const auto length = [](const LitView& view) { return view.light.position.norm(); };
  const auto [near, far] = std::minmax_element(
      views.begin(), views.end(), [&](const LitView& a, const LitView& b) { return length(a) < length(b); });
  const bool dome = length(*far) <= (1 + kUnitWithin) * length(*near);
  return file + ": " + count +
         (dome
              ? format(" lights of length %.3g are taken for places on a dome of that radius, in metres", length(*far))
              : format(" lights of length %.3g to %.3g are taken for places, in metres", length(*near), length(*far))) +
         "; if they are directions of far lights, whose lengths say nothing, " + may_say("directions");
}

std::vector<LitView> load_lights(const fs::path& list) {
  return parse_light_list(list.string(), read_file(list, kMostListBytes));
}

}  // namespace sheen
