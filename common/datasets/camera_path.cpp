// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/camera_path.h"

#include <cmath>

#include "common/base/format.h"
#include "common/base/json_fields.h"
#include "common/datasets/pose_check.h"

namespace sheen {

namespace {

using Json = nlohmann::json;

constexpr int kMostSide = 1 << 16;
constexpr double kAnyNumber = 1e30;  // `place_error` knows the true limit

Rigid3 parse_pose(const JsonFields& fields, const Json& json, const std::string& where) {
  const std::string field = where + "camera_to_world";
  const Json& numbers = fields.array(fields.member(json, "camera_to_world", where), field, 16, 16);
  Eigen::Matrix4d object_from_gl;
  for (Eigen::Index i = 0; i < 16; ++i)
    object_from_gl(i / 4, i % 4) = fields.number(numbers[static_cast<std::size_t>(i)], field, -kAnyNumber, kAnyNumber);
  Eigen::Matrix3d rotation = object_from_gl.topLeftCorner<3, 3>();
  if (const std::string wrong = make_rotation(rotation); !wrong.empty()) fields.fail(field, wrong);
  if (const std::string wrong = place_error(object_from_gl.topRightCorner<3, 1>()); !wrong.empty())
    fields.fail(field, wrong);
  if (object_from_gl.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) fields.fail(field, "must end with 0 0 0 1");
  object_from_gl.topLeftCorner<3, 3>() = rotation;
  return Rigid3::from_matrix(object_from_gl * Eigen::Vector4d(1, -1, -1, 1).asDiagonal()).inverse();
}

}  // namespace

std::optional<std::vector<DatasetView>> parse_camera_path(const std::string& file, const std::string& text) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("camera_path") || json.contains("frames")) return std::nullopt;
  const JsonFields fields(file);
  if (const auto type = json.find("camera_type"); type != json.end() && *type != "perspective")
    fields.fail("camera_type", "must be \"perspective\": other cameras cannot be rendered");
  Camera camera;
  camera.width =
      static_cast<int>(fields.integer(fields.member(json, "render_width", ""), "render_width", 1, kMostSide));
  camera.height =
      static_cast<int>(fields.integer(fields.member(json, "render_height", ""), "render_height", 1, kMostSide));
  camera.cx = (camera.width - 1) / 2.0;
  camera.cy = (camera.height - 1) / 2.0;
  const Json& path = json.at("camera_path");
  if (!path.is_array() || path.empty()) fields.fail("camera_path", "must be a list of at least one camera");
  std::vector<DatasetView> views;
  for (const Json& entry : path) {
    const std::string where = "camera_path[" + std::to_string(views.size()) + "].";
    DatasetView view;
    view.name = format("%05zu", views.size());
    view.camera_from_object = parse_pose(fields, entry, where);
    const double degrees = fields.number(fields.member(entry, "fov", where), where + "fov", 0.01, 179);
    camera.fx = camera.fy = camera.height / 2.0 / std::tan(degrees * M_PI / 360);
    if (const std::string wrong = validation_error(camera); !wrong.empty()) fields.fail(where + "fov", wrong);
    view.camera = camera;
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace sheen
