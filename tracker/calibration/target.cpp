// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/target.h"

#include <charconv>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/quantity.h"
#include "common/stage/tag_pattern.h"

namespace sheen {
namespace {

constexpr int kMostAlongSide = 100;

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw ConfigError("--target " + text + ": " + why + "; it takes " + kTargetSyntax);
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == separator)
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// "9x6", each from `least`.
void parse_counts(const std::string& target, const std::string& word, int least, int& columns, int& rows) {
  const auto parts = split(word, 'x');
  const auto count = [&](const std::string& digits) {
    int value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || value < least || value > kMostAlongSide)
      refuse(target, "\"" + word + "\" must be two numbers from " + std::to_string(least) + " to " +
                         std::to_string(kMostAlongSide) + ", as 9x6");
    return value;
  };
  if (parts.size() != 2) refuse(target, "\"" + word + "\" must be two numbers, as 9x6");
  columns = count(parts[0]);
  rows = count(parts[1]);
}

double parse_side(const std::string& word) {
  return parse_length_m("--target", word, "a length, as 25mm");
}

/// Kalibr's AprilGrid: ids from 0 at the lower left, row by row upwards.
StageLayout april_grid(int columns, int rows, double side, double gap) {
  const double step = side * (1 + gap);
  StageLayout layout{.width_m = columns * step, .height_m = rows * step};
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const double x = column * step, y = row * step;
      layout.tags.push_back(
          {row * columns + column, {{{x, y + side, 0}, {x + side, y + side, 0}, {x + side, y, 0}, {x, y, 0}}}});
    }
  return layout;
}

void add_grid_points(CalibrationTarget& target, int columns, int rows) {
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      target.points.emplace_back(column * target.square_m, row * target.square_m, 0);
}

}  // namespace

std::string CalibrationTarget::point_name(int point) const {
  if (kind != TargetKind::kTags) return "corner " + std::to_string(point);
  return "tag " + std::to_string(tags.tags[point / 4].id) + " corner " + std::to_string(point % 4);
}

CalibrationTarget parse_target(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  CalibrationTarget target;
  if (kind == "stage") {
    if (colon == std::string::npos || colon + 1 == text.size()) refuse(text, "the file of the stage is missing");
    target.kind = TargetKind::kTags;
    target.tags = load_stage(text.substr(colon + 1));
  } else {
    const auto words = split(text, ':');
    const auto require_words = [&](std::size_t least, std::size_t most) {
      if (words.size() < least || words.size() > most) refuse(text, "a part is missing or too many");
    };
    if (kind == "chessboard") {
      require_words(3, 3);
      parse_counts(text, words[1], 3, target.columns, target.rows);
      target.square_m = parse_side(words[2]);
      add_grid_points(target, target.columns, target.rows);
    } else if (kind == "charuco") {
      require_words(4, 5);
      target.kind = TargetKind::kCharuco;
      parse_counts(text, words[1], 3, target.columns, target.rows);
      target.square_m = parse_side(words[2]);
      target.marker_m = parse_side(words[3]);
      if (target.marker_m >= target.square_m) refuse(text, "a marker must be smaller than its square");
      target.dictionary = words.size() == 5 ? words[4] : "DICT_4X4_250";
      add_grid_points(target, target.columns - 1, target.rows - 1);
    } else if (kind == "aprilgrid") {
      require_words(4, 4);
      target.kind = TargetKind::kTags;
      parse_counts(text, words[1], 1, target.columns, target.rows);
      if (target.columns * target.rows > kTagIdCount) refuse(text, "tag36h11 has 587 tags only");
      double gap = 0;
      const auto [end, error] = std::from_chars(words[3].data(), words[3].data() + words[3].size(), gap);
      if (error != std::errc{} || end != words[3].data() + words[3].size() || !(gap > 0) || !(gap <= 10))
        refuse(text, "the gap \"" + words[3] + "\" must be a part of the tag's side, as 0.3");
      target.square_m = parse_side(words[2]);
      target.tags = april_grid(target.columns, target.rows, target.square_m, gap);
    } else {
      refuse(text, "\"" + kind + "\" is no kind of target");
    }
  }
  for (const StageTag& tag : target.tags.tags)
    target.points.insert(target.points.end(), tag.corners_object.begin(), tag.corners_object.end());
  return target;
}

}  // namespace sheen
