// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/view_controls.h"

#include <algorithm>

#include "reconstructor/render/best_lit_view.h"
#include "reconstructor/render/gl/light_ball.h"

namespace sheen {
namespace {

/// About the bounding box's middle, and no larger than the mesh needs.
BoundingSphere tight_sphere(const Mesh& mesh) {
  BoundingSphere sphere = bounding_sphere(mesh);
  sphere.radius = 0;
  for (const Eigen::Vector3f& v : mesh.vertices)
    sphere.radius = std::max(sphere.radius, (v.cast<double>() - sphere.centre).norm());
  return sphere;
}

/// Of those at hand the one that is most from the upper left of the picture, as in drawings.
Eigen::Vector3d first_light(const std::vector<Eigen::Vector3d>& lights, const Rigid3& camera_from_object) {
  const Eigen::Vector3d wanted = picture_axes(camera_from_object).transpose() * Eigen::Vector3d(-0.5, 0.6, 0.62);
  const auto like_wanted = [&](const Eigen::Vector3d& light) { return light.dot(wanted); };
  return lights.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : *std::ranges::max_element(lights, {}, like_wanted);
}

}  // namespace

std::vector<Eigen::Vector3d> light_directions(const ModelSnapshot& model) {
  std::vector<Eigen::Vector3d> directions;
  for (const LightState& light : model.lights()) directions.push_back(light.position.normalized());
  return directions;
}

const char* to_string(ViewMode mode) {
  switch (mode) {
    case ViewMode::kAppearance:
      return "appearance";
    case ViewMode::kHeuristic:
      return "heuristic";
    case ViewMode::kSplit:
      return "split";
    case ViewMode::kCamera:
      return "camera";
    case ViewMode::kRank:
    case ViewMode::kResolution:
    case ViewMode::kBytes:
      return to_string(*demand_of(mode));
    case ViewMode::kShape:
      return "shape";
  }
  return "unknown";
}

std::optional<Demand> demand_of(ViewMode mode) {
  switch (mode) {
    case ViewMode::kRank:
      return Demand::kRank;
    case ViewMode::kResolution:
      return Demand::kResolution;
    case ViewMode::kBytes:
      return Demand::kBytes;
    default:
      return std::nullopt;
  }
}

std::optional<ViewMode> view_mode_from(std::string_view word) {
  for (const ViewMode mode : {ViewMode::kAppearance, ViewMode::kHeuristic, ViewMode::kSplit, ViewMode::kCamera,
                              ViewMode::kRank, ViewMode::kResolution, ViewMode::kBytes})
    if (word == to_string(mode)) return mode;
  return std::nullopt;
}

Ground next(Ground ground) {
  return ground == Ground::kBlack ? Ground::kDark : static_cast<Ground>(static_cast<int>(ground) + 1);
}

Eigen::Vector3f color_of(Ground ground) {
  switch (ground) {
    case Ground::kDark:
      return {0.11f, 0.12f, 0.135f};
    case Ground::kGrey:
      return {0.46f, 0.46f, 0.46f};
    case Ground::kLight:
      return {0.91f, 0.91f, 0.90f};
    case Ground::kWhite:
      return {1, 1, 1};
    case Ground::kBlack:
      break;
  }
  return {0, 0, 0};
}

void ViewControls::frame(const std::shared_ptr<const Mesh>& mesh) {
  if (!mesh || mesh == framed_) return;
  framed_ = mesh;
  opening_.reset();
  without_colours_ = false;
  lights_.clear();
  stand_where_it_opens();
}

void ViewControls::frame(const ModelSnapshot& model) {
  const bool again = model.shared_mesh() == framed_;
  if (again && !(without_colours_ && opening_ && !model.empty())) return;
  const bool moved = again && !(orbit.viewpoint(1, 1) == stood_);
  framed_ = model.shared_mesh();
  opening_ = best_lit_view(model);
  lights_ = light_directions(model);
  without_colours_ = model.empty();
  if (!moved) stand_where_it_opens();
}

void ViewControls::reset() {
  follow = false;
  if (framed_) stand_where_it_opens();
}

void ViewControls::stand_where_it_opens() {
  orbit.frame(tight_sphere(*framed_));
  if (opening_) {
    orbit.set_up(opening_->up);
    orbit.look_from(opening_->direction);
  }
  if (eye) orbit.place(*eye - framed_->origin);
  stood_ = orbit.viewpoint(1, 1);
  light = first_light(lights_, stood_.camera_from_object);
}

void ViewControls::turn_light(double right_rad, double up_rad) {
  if (light.isZero()) return;
  const Eigen::Matrix3d axes = picture_axes(orbit.viewpoint(1, 1).camera_from_object);
  light = axes.transpose() * turned_light(axes * light, right_rad, up_rad);
}

}  // namespace sheen
