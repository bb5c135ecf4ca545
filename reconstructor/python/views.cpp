// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/python/views.h"

#include <Eigen/LU>
#include <array>
#include <string>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/capture/moved_origin.h"
#include "reconstructor/commands/move_request.h"
#include "reconstructor/render/camera_moves.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

constexpr int kWidth = 640, kHeight = 480;
constexpr double kFieldDegrees = 40;  // as window and page have it
constexpr double kNarrowest = 1, kWidest = 150;
constexpr double kLargestCoordinate = 1e9;  // metres
constexpr double kRigid = 1e-4;             // of what a rotation's columns may be off

void require_finite(const char* name, const auto& numbers) {
  if (!(numbers.array().abs() <= kLargestCoordinate).all())
    throw ConfigError(std::string(name) + ": must be numbers within 1e9");
}

PosedCamera checked(const PosedCamera& posed) {
  if (const std::string wrong = validation_error(posed.camera); !wrong.empty()) throw ConfigError(wrong);
  return posed;
}

ImageSize size_of(const AskedView& asked) {
  return {asked.width.value_or(kWidth), asked.height.value_or(kHeight)};
}

PosedCamera looking(const AskedView& asked, const ModelSnapshot& model) {
  if (!asked.eye || !asked.target)
    throw ConfigError("eye and target: both are needed, or intrinsics and camera_from_object");
  const LookAt view{*asked.eye, *asked.target, asked.up ? *asked.up : first_view(model).up};
  require_finite("eye", view.eye);
  require_finite("target", view.target);
  require_finite("up", view.up);
  if (!is_a_view(view)) throw ConfigError("eye, target and up: the camera looks nowhere, or along its up direction");
  const double field = asked.field_of_view.value_or(kFieldDegrees);
  if (!(field >= kNarrowest && field <= kWidest))
    throw ConfigError(format("field_of_view: must be %.0f..%.0f degrees", kNarrowest, kWidest));
  return with_field(std::array{view}, field, size_of(asked)).front();
}

PosedCamera by_matrices(const AskedView& asked) {
  if (!asked.intrinsics || !asked.camera_from_object)
    throw ConfigError("intrinsics and camera_from_object: both are needed, or eye and target");
  const Eigen::Matrix3d& k = *asked.intrinsics;
  require_finite("intrinsics", k);
  if (k(0, 1) != 0 || k(1, 0) != 0 || k.row(2) != Eigen::RowVector3d::UnitZ())
    throw ConfigError("intrinsics: must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]");
  const Eigen::Matrix4d& pose = *asked.camera_from_object;
  require_finite("camera_from_object", pose);
  const Eigen::Matrix3d turn = pose.topLeftCorner<3, 3>();
  if (!(turn * turn.transpose()).isIdentity(kRigid) || turn.determinant() < 0 ||
      pose.row(3) != Eigen::RowVector4d::UnitW())
    throw ConfigError(
        "camera_from_object: must be [[R, t], [0, 0, 0, 1]] with a rotation R (OpenCV axes: x right, y down, z "
        "forward)");
  const ImageSize size = size_of(asked);
  return {{.width = size.width, .height = size.height, .fx = k(0, 0), .fy = k(1, 1), .cx = k(0, 2), .cy = k(1, 2)},
          Rigid3::from_matrix(pose)};
}

PosedCamera in_size(const AskedView& asked, PosedCamera camera) {
  camera.camera =
      camera.camera.scaled(asked.width.value_or(camera.camera.width), asked.height.value_or(camera.camera.height));
  return camera;
}

PosedCamera first_camera(const AskedView& asked, const ModelSnapshot& model) {
  const PosedCamera camera = model.cameras().size() == 1
                                 ? in_size(asked, model.cameras().front())
                                 : framed(std::array{first_view(model)}, model.mesh(), size_of(asked)).front();
  return in_frame_at(-model.mesh().origin, camera);
}

}  // namespace

PosedCamera camera_of(const AskedView& asked, const ModelSnapshot& model) {
  if (model.cameras().empty()) throw ConfigError("the model has no image");
  if (asked.width.value_or(1) < 1 || asked.height.value_or(1) < 1)
    throw ConfigError("width and height: must be 1 or more");
  const bool looks = asked.eye || asked.target || asked.up || asked.field_of_view;
  const bool matrices = asked.intrinsics || asked.camera_from_object;
  if (asked.camera && (looks || matrices)) throw ConfigError("camera: needs no eye, target, intrinsics and the like");
  if (asked.camera) return checked(in_size(asked, *asked.camera));
  if (looks && matrices)
    throw ConfigError(
        "give eye and target (with up and field_of_view), or intrinsics and camera_from_object, not both");
  if (looks) return checked(looking(asked, model));
  if (matrices) return checked(by_matrices(asked));
  return checked(first_camera(asked, model));
}

LightState light_of(const std::optional<Vector3d>& light, const ModelSnapshot& model) {
  if (!light) {
    const std::vector<LightState> lights = model.lights();
    return lights.empty() ? LightState{} : in_frame_at(-model.mesh().origin, lights.front());
  }
  if (model.light_kind() == LightKind::kFixed) throw ConfigError("light: the light of this model is fixed");
  require_finite("light", *light);
  if (model.light_kind() == LightKind::kPoint) return {model.light_kind(), *light};
  if (!(light->norm() > 1e-9)) throw ConfigError("light: must be a direction, and has no length");
  return {model.light_kind(), light->normalized()};
}

}  // namespace sheen
