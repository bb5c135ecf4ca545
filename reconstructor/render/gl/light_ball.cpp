// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/light_ball.h"

#include <algorithm>
#include <cmath>

#include "common/base/angle.h"
#include "common/base/format.h"

namespace sheen {
namespace {

constexpr double kLowest = 0.05;  // sine above the picture: lower, light meets nothing

}  // namespace

Eigen::Matrix3d picture_axes(const Rigid3& camera_from_object) {
  const Eigen::Matrix3d camera = camera_from_object.rotation.toRotationMatrix();
  return Eigen::Vector3d(1, -1, -1).asDiagonal() * camera;
}

Eigen::Vector3d turned_light(const Eigen::Vector3d& light, double right, double up) {
  const double steepest = M_PI / 2 - kLowest;
  const double elevation = std::clamp(std::asin(std::clamp(light.y(), -1.0, 1.0)) + up, -steepest, steepest);
  const double level = std::cos(elevation);
  const double most = std::acos(std::min(1.0, kLowest / level));
  const double azimuth = std::clamp(std::atan2(light.x(), light.z()) + right, -most, most);
  return {level * std::sin(azimuth), std::sin(elevation), level * std::cos(azimuth)};
}

Eigen::Vector3d light_at(const Eigen::Vector2d& place) {
  const double most = std::sqrt(1 - kLowest * kLowest), away = place.norm();
  const Eigen::Vector2d on = away > most ? Eigen::Vector2d(place * (most / away)) : place;
  return {on.x(), on.y(), std::sqrt(1 - on.squaredNorm())};
}

std::string light_in_words(const Eigen::Vector3d& light) {
  constexpr const char* kSides[] = {"the right", "the upper right", "above", "the upper left",
                                    "the left",  "the lower left",  "below", "the lower right"};
  constexpr double kFrontDeg = 80;
  const double above_deg = std::asin(std::clamp(light.z(), -1.0, 1.0)) / kDegree;
  if (above_deg > kFrontDeg) return "Light from the front";
  const long eighth = std::lround(std::atan2(light.y(), light.x()) / (M_PI / 4));
  return format("Light from %s, %ld degrees off the picture", kSides[(eighth + 8) % 8], std::lround(above_deg));
}

}  // namespace sheen
