// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/orbit_camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr double kTanHalfView = 0.36397023426620234;  // tan 20 degrees
constexpr double kSteepest = 1.5;                     // rad: short of the pole, where azimuth means nothing

}  // namespace

void OrbitCamera::frame(const BoundingSphere& object) {
  target_ = object.centre;
  radius_ = std::max(object.radius, 1e-9);
  distance_ = 1.05 * radius_ / std::sin(std::atan(kTanHalfView));
  azimuth_ = -0.9;
  elevation_ = 0.5;
}

void OrbitCamera::set_up(const Eigen::Vector3d& up) {
  frame_ = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up).toRotationMatrix();
}

void OrbitCamera::look_from(const Eigen::Vector3d& direction) {
  place(target_ + distance_ * direction);
}

void OrbitCamera::place(const Eigen::Vector3d& eye) {
  const Eigen::Vector3d offset = frame_.transpose() * (eye - target_);
  const double distance = offset.norm();
  if (!(distance > 1e-6 * radius_)) return;
  distance_ = distance;
  azimuth_ = std::atan2(offset.y(), offset.x());
  elevation_ = std::clamp(std::asin(std::clamp(offset.z() / distance, -1.0, 1.0)), -kSteepest, kSteepest);
}

void OrbitCamera::orbit(double right_rad, double up_rad) {
  azimuth_ = std::remainder(azimuth_ + right_rad, 2 * M_PI);
  elevation_ = std::clamp(elevation_ + up_rad, -kSteepest, kSteepest);
}

void OrbitCamera::pan(double right, double up) {
  const Eigen::Vector3d forward = -direction();
  const Eigen::Vector3d across = forward.cross(frame_.col(2)).normalized();
  const double height = 2 * kTanHalfView * distance_;  // of the picture, at the target
  target_ += height * (right * across + up * across.cross(forward));
}

void OrbitCamera::dolly(double factor) {
  distance_ = std::clamp(distance_ * factor, 0.05 * radius_, 100 * radius_);
}

Eigen::Vector3d OrbitCamera::direction() const {
  return frame_ * Eigen::Vector3d(std::cos(elevation_) * std::cos(azimuth_), std::cos(elevation_) * std::sin(azimuth_),
                                  std::sin(elevation_));
}

Viewpoint OrbitCamera::viewpoint(int width, int height) const {
  Camera camera{.width = width, .height = height};
  camera.fx = camera.fy = 0.5 * std::min(width, height) / kTanHalfView;
  camera.cx = 0.5 * width - 0.5;
  camera.cy = 0.5 * height - 0.5;
  return {camera, look_at(target_ + distance_ * direction(), target_, frame_.col(2))};
}

}  // namespace sheen
