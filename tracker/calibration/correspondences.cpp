// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/correspondences.h"

#include <set>

#include "common/base/json_fields.h"

namespace sheen {
namespace {

using Json = nlohmann::json;
constexpr double kFarthest = 1e6;

Eigen::Vector3d vector3(const JsonFields& fields, const Json& value, const std::string& field, double unit) {
  fields.array(value, field, 3, 3);
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i)
    v[i] = unit * fields.number(value[i], field + "[" + std::to_string(i) + "]", -kFarthest, kFarthest);
  return v;
}

double unit_of(const JsonFields& fields, const Json& file) {
  const std::string unit = file.contains("stage_unit") ? fields.text(file["stage_unit"], "stage_unit") : "m";
  if (unit == "m") return 1;
  if (unit == "cm") return 1e-2;
  if (unit == "mm") return 1e-3;
  fields.fail("stage_unit", "must be \"m\", \"cm\" or \"mm\"");
}

PickedPoint read_point(const JsonFields& fields, const Json& entry, const std::string& where, double unit) {
  PickedPoint point;
  point.name = fields.text(fields.member(entry, "name", where), where + "name");
  point.mesh = vector3(fields, fields.member(entry, "mesh", where), where + "mesh", 1);
  const bool on_stage = entry.contains("stage"), in_images = entry.contains("pixels");
  if (on_stage == in_images)
    fields.fail(where + "stage", on_stage ? "is there beside \"pixels\"; give one of them"
                                          : "is missing, and \"pixels\" too; give one of them");
  if (on_stage) {
    point.stage = vector3(fields, entry["stage"], where + "stage", unit);
    return point;
  }
  const Json& pixels = entry["pixels"];
  if (!pixels.is_object() || pixels.size() < 2)
    fields.fail(where + "pixels", "must map two or more images to [x, y], so that the point's place follows");
  for (const auto& [image, at] : pixels.items()) {
    const std::string field = where + "pixels." + image;
    fields.array(at, field, 2, 2);
    point.pixels.push_back({image,
                            {fields.number(at[0], field + "[0]", -kFarthest, kFarthest),
                             fields.number(at[1], field + "[1]", -kFarthest, kFarthest)}});
  }
  return point;
}

}  // namespace

Correspondences load_correspondences(const std::filesystem::path& path) {
  const JsonFields fields(path);
  const Json file = fields.open("sheen-correspondences", 1, "the user guide shows such a file under \"Register\"");
  const double unit = unit_of(fields, file);
  Correspondences read;
  if (file.contains("stage_uncertainty"))
    read.stage_uncertainty_m = unit * fields.number(file["stage_uncertainty"], "stage_uncertainty", 1e-9, kFarthest);
  if (file.contains("pixel_uncertainty"))
    read.pixel_uncertainty_px = fields.number(file["pixel_uncertainty"], "pixel_uncertainty", 1e-6, 1e4);
  const Json& points = fields.array(fields.member(file, "points", ""), "points", 1, 10000);
  std::set<std::string> names;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::string where = "points[" + std::to_string(i) + "].";
    read.points.push_back(read_point(fields, points[i], where, unit));
    if (!names.insert(read.points.back().name).second)
      fields.fail(where + "name", "is \"" + read.points.back().name + "\" a second time");
  }
  return read;
}

}  // namespace sheen
