// SPDX-License-Identifier: Apache-2.0
#include "common/stage/stage_layout.h"

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/json_fields.h"
#include "common/stage/tag_pattern.h"

namespace sheen {
namespace {

using nlohmann::json;

constexpr char kFormat[] = "sheen-stage";
constexpr int kVersion = 1;
constexpr char kFamily[] = "tag36h11";
constexpr double kLargestLength = 10, kSmallestBoard = 0.01;  // metres
constexpr std::size_t kMinTags = 4;                           // fewer do not surround an object

std::string millimetres(double metres) {
  return format("%g mm", metres * 1e3);
}

void require_length(double value, const char* field, bool zero_allowed = false) {
  if (!std::isfinite(value) || value < 0 || (value == 0 && !zero_allowed) || value > kLargestLength)
    throw ConfigError(std::string("stage: ") + field + " is " + millimetres(value) +
                      "; it must be a length up to 10 m");
}

/// Tags that fit along a side that is `length` long between its margins.
int tags_along(double length, double footprint) {
  return static_cast<int>(std::floor(length / footprint + 1e-9));
}

StageTag upright_tag(int id, double x, double y, double side) {
  const double h = side / 2;
  return {id, {{{x - h, y + h, 0}, {x + h, y + h, 0}, {x + h, y - h, 0}, {x - h, y - h, 0}}}};
}

StageTag read_tag(const JsonFields& fields, const json& entry, const std::string& where) {
  StageTag tag;
  tag.id = static_cast<int>(fields.integer(fields.member(entry, "id", where), where + "id", 0, kTagIdCount - 1));
  const std::string field = where + "corners_m";
  const json& corners = fields.array(fields.member(entry, "corners_m", where), field, 4, 4);
  for (std::size_t c = 0; c < 4; ++c) {
    fields.array(corners[c], field, 3, 3);
    for (int axis = 0; axis < 3; ++axis)
      tag.corners_object[c][axis] = fields.number(corners[c][axis], field, -kLargestLength, kLargestLength);
  }
  const auto& q = tag.corners_object;
  const Eigen::Vector3d normal = (q[2] - q[0]).cross(q[3] - q[1]);  // twice the area; clockwise from above, so -z
  if (!(normal.norm() > 1e-8)) fields.fail(field, "spans no area");
  if (normal.z() > 0)
    fields.fail(field, "runs the wrong way round; list top left, top right, bottom right, bottom left seen from +z");
  return tag;
}

}  // namespace

const StageTag* StageLayout::find(int id) const {
  for (const StageTag& tag : tags)
    if (tag.id == id) return &tag;
  return nullptr;
}

std::string StageLayout::hash() const {
  std::string layout = family;
  for (const StageTag& tag : tags) {
    layout += ' ' + std::to_string(tag.id);
    for (const Eigen::Vector3d& corner : tag.corners_object)
      for (const double coordinate : corner) layout += format(" %.17g", coordinate + 0.0);  // -0 is 0
  }
  return content_hash(layout);
}

StageLayout make_stage(const StageOptions& options) {
  require_length(options.width_m, "width");
  require_length(options.height_m, "height");
  require_length(options.tag_m, "tag size");
  require_length(options.margin_m, "margin", true);
  // Every tag keeps one white cell on each side, so neighbours are two apart.
  const double cell = options.tag_m / kTagCells, footprint = options.tag_m + 2 * cell;
  const double inner_width = options.width_m - 2 * options.margin_m;
  const double inner_height = options.height_m - 2 * options.margin_m;
  const int columns = tags_along(inner_width, footprint), rows = tags_along(inner_height, footprint);
  if (columns < 3 || rows < 3)
    throw ConfigError("stage: a board of " + millimetres(options.width_m) + " x " + millimetres(options.height_m) +
                      " holds too few tags of " + millimetres(options.tag_m) +
                      "; take smaller tags or a larger board (at least three tags per side)");
  const int count = 2 * columns + 2 * (rows - 2);
  if (options.first_id < 0 || options.first_id + count > kTagIdCount)
    throw ConfigError("stage: first id " + std::to_string(options.first_id) + " leaves no room for " +
                      std::to_string(count) + " tags among the ids 0.." + std::to_string(kTagIdCount - 1));

  StageLayout stage{.family = kFamily, .width_m = options.width_m, .height_m = options.height_m};
  const auto x = [&](int column) { return (inner_width - footprint) * (double(column) / (columns - 1) - 0.5); };
  const auto y = [&](int row) { return (inner_height - footprint) * (0.5 - double(row) / (rows - 1)); };
  int id = options.first_id;
  const auto put = [&](int column, int row) {
    stage.tags.push_back(upright_tag(id++, x(column), y(row), options.tag_m));
  };
  // Clockwise from the top left, seen from above.
  for (int column = 0; column < columns; ++column) put(column, 0);
  for (int row = 1; row < rows; ++row) put(columns - 1, row);
  for (int column = columns - 2; column >= 0; --column) put(column, rows - 1);
  for (int row = rows - 2; row >= 1; --row) put(0, row);
  return stage;
}

StageLayout load_stage(const std::filesystem::path& path) {
  const JsonFields fields(path);
  const json file = fields.open(kFormat, kVersion, "make one with `sheen-tracker stage`");
  if (fields.member(file, "family", "") != kFamily) fields.fail("family", "must be \"tag36h11\"");

  StageLayout stage{.family = kFamily};
  stage.width_m = fields.number(fields.member(file, "width_m", ""), "width_m", kSmallestBoard, kLargestLength);
  stage.height_m = fields.number(fields.member(file, "height_m", ""), "height_m", kSmallestBoard, kLargestLength);
  const json& tags = fields.array(fields.member(file, "tags", ""), "tags", kMinTags, kTagIdCount);
  std::set<int> ids;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const std::string where = "tags[" + std::to_string(i) + "].";
    stage.tags.push_back(read_tag(fields, tags[i], where));
    if (!ids.insert(stage.tags.back().id).second) fields.fail(where + "id", "is listed twice");
  }
  return stage;
}

void save_stage(const StageLayout& stage, const std::filesystem::path& path) {
  json tags = json::array();
  for (const StageTag& tag : stage.tags) {
    json corners = json::array();
    for (const Eigen::Vector3d& c : tag.corners_object) corners.push_back({c.x(), c.y(), c.z()});
    tags.push_back({{"id", tag.id}, {"corners_m", corners}});
  }
  const json file = {{"format", kFormat},        {"version", kVersion},        {"family", stage.family},
                     {"width_m", stage.width_m}, {"height_m", stage.height_m}, {"tags", tags}};
  write_file(path, file.dump(1) + "\n");
}

}  // namespace sheen
