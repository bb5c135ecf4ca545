// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/guidance.h"

#include <cmath>

#include "common/base/angle.h"

namespace sheen {
namespace {

constexpr double kThereDeg = 4;
constexpr double kSteepDeg = 75;  ///< of elevation: beyond it nobody walks round

double azimuth_deg(const Eigen::Vector3d& direction) {
  return std::atan2(direction.y(), direction.x()) / kDegree;
}

double elevation_deg(const Eigen::Vector3d& direction) {
  return std::atan2(direction.z(), direction.head<2>().norm()) / kDegree;
}

}  // namespace

bool Guidance::there() const {
  return std::hypot(right_deg, up_deg) < kThereDeg;
}

Guidance guide(const Rigid3& camera_from_object, const Eigen::Vector3d& centre, const Eigen::Vector3d& next_eye) {
  const Eigen::Matrix3d camera = camera_from_object.rotation.toRotationMatrix();
  const Eigen::Vector3d out = (camera_centre(camera_from_object) - centre).normalized();
  const Eigen::Vector3d image_up = -camera.row(1).transpose();
  const Eigen::Vector3d right = image_up.cross(out).normalized();
  const Eigen::Vector3d up = out.cross(right);
  const Eigen::Vector3d next = (next_eye - centre).normalized();
  if (std::abs(elevation_deg(out)) < kSteepDeg && std::abs(elevation_deg(next)) < kSteepDeg)
    return {std::remainder(azimuth_deg(next) - azimuth_deg(out), 360), elevation_deg(next) - elevation_deg(out)};
  const Eigen::Vector2d across(next.dot(right), next.dot(up));
  const double degrees = std::atan2(across.norm(), next.dot(out)) / kDegree;
  const Eigen::Vector2d way = across.norm() > 1e-9 ? Eigen::Vector2d(across.normalized()) : Eigen::Vector2d(1, 0);
  return {degrees * way.x(), degrees * way.y()};
}

std::string in_words(const Guidance& guidance) {
  if (guidance.there()) return "here, hold still";
  const auto whole = [](double degrees) { return std::to_string(std::lround(std::abs(degrees))); };
  const bool across = std::abs(guidance.right_deg) >= 1, along = std::abs(guidance.up_deg) >= 1;
  const char* const up = guidance.up_deg > 0 ? " up" : " down";
  if (!across) return whole(guidance.up_deg) + " degrees" + up;
  return whole(guidance.right_deg) + " degrees to the " + (guidance.right_deg > 0 ? "right" : "left") +
         (along ? ", " + whole(guidance.up_deg) + up : "");
}

std::string advice_in_words(const Guidance& guidance, const std::string& reason) {
  return (guidance.there() ? "" : "move ") + in_words(guidance) + (reason.empty() ? "" : ": " + reason);
}

}  // namespace sheen
