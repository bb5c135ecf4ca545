// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/best_lit_view.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/image/color.h"

namespace sheen {
namespace {

constexpr std::size_t kMostCameras = 12, kMostTriangles = 500;  // looked at: a tenth of a second
constexpr double kAsHigh = 0.15;                                // of the sine of the elevation

/// Every nth, so that no more than `most` remain.
template <typename T>
std::vector<T> thinned(const std::vector<T>& all, std::size_t most) {
  const std::size_t step = all.size() / most + 1;
  std::vector<T> some;
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

/// Mean of the encoded levels of what faces the eye, by the area that it takes; what hides what is not asked.
double brightness(const ModelSnapshot& model, const Eigen::Vector3d& eye) {
  const Mesh& mesh = model.mesh();
  const std::unique_ptr<ViewShader> shader = model.shader_for({.eye = eye});
  const std::size_t step = mesh.triangles.size() / kMostTriangles + 1;
  double sum = 0, area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += step) {
    const Eigen::Vector3f towards = (eye.cast<float>() - mesh.corner(t, 0)).normalized();
    const double facing = mesh.area_normal(t).dot(towards);
    if (facing <= 0) continue;
    constexpr float kMiddle = 1.0f / 3;
    const Eigen::Vector3f rgb = shader->shade(static_cast<std::uint32_t>(t), kMiddle, kMiddle).rgb;
    sum += facing * srgb_encode(std::clamp(rgb.mean(), 0.0f, 1.0f));
    area += facing;
  }
  return area > 0 ? sum / area : 0;
}

}  // namespace

std::optional<OpeningView> best_lit_view(const ModelSnapshot& model) {
  const Eigen::Vector3d centre = bounding_sphere(model.mesh()).centre;
  std::optional<OpeningView> view = opening_view(model.cameras(), centre);
  if (!view || model.empty() || model.light_kind() != LightKind::kFixed) return view;
  std::vector<Eigen::Vector3d> eyes;
  for (const PosedCamera& camera : model.cameras()) {
    const Eigen::Vector3d eye = camera_centre(camera.camera_from_object);
    const double height = (eye - centre).normalized().dot(view->up);
    if (std::abs(height - view->direction.dot(view->up)) < kAsHigh) eyes.push_back(eye);
  }
  double best = -1;
  for (const Eigen::Vector3d& eye : thinned(eyes, kMostCameras)) {
    const double here = brightness(model, eye);
    if (here <= best) continue;
    best = here;
    view->direction = (eye - centre).normalized();
  }
  return view;
}

}  // namespace sheen
