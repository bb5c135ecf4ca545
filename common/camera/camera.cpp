// SPDX-License-Identifier: Apache-2.0
#include "common/camera/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

namespace sheen {
namespace {

/// Brown-Conrady: normalised undistorted -> distorted coordinates, with the Jacobian of that map.
Eigen::Vector2d distort_opencv(const std::array<double, 5>& k, const Eigen::Vector2d& p, Eigen::Matrix2d* jacobian) {
  const auto [k1, k2, p1, p2, k3] = k;
  const double x = p.x(), y = p.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  if (jacobian) {
    const double d_radial = k1 + r2 * (2 * k2 + r2 * 3 * k3);  // d radial / d r2
    (*jacobian)(0, 0) = radial + 2 * x * x * d_radial + 2 * p1 * y + 6 * p2 * x;
    (*jacobian)(0, 1) = 2 * x * y * d_radial + 2 * p1 * x + 2 * p2 * y;
    (*jacobian)(1, 0) = (*jacobian)(0, 1);
    (*jacobian)(1, 1) = radial + 2 * y * y * d_radial + 6 * p1 * y + 2 * p2 * x;
  }
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

/// Equidistant: angle to the axis -> distorted angle, with its derivative.
double distort_angle(const std::array<double, 5>& k, double theta, double* derivative) {
  const double t2 = theta * theta;
  if (derivative) *derivative = 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
  return theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

constexpr int kNewtonSteps = 20;

}  // namespace

bool Camera::has_distortion() const {
  if (lens == LensModel::kFisheye) return true;  // even with zero coefficients it is no pinhole
  for (const double k : distortion)
    if (k != 0) return true;
  return false;
}

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& point) const {
  if (lens == LensModel::kFisheye) {
    const double r = std::hypot(point.x(), point.y());
    const double theta = std::atan2(r, point.z());
    double slope = 0;
    const double distorted = distort_angle(distortion, theta, &slope);
    if (slope <= 0 || distorted < 0) return std::nullopt;
    const double scale = r > 1e-12 ? distorted / r : 1 / std::max(point.z(), 1e-12);
    return Eigen::Vector2d(fx * point.x() * scale + cx, fy * point.y() * scale + cy);
  }
  if (!(point.z() > 1e-9)) return std::nullopt;
  Eigen::Vector2d p(point.x() / point.z(), point.y() / point.z());
  if (has_distortion()) {
    Eigen::Matrix2d jacobian;
    const Eigen::Vector2d distorted = distort_opencv(distortion, p, &jacobian);
    // Past the fold the polynomial turns back and would put far-off points into the picture.
    if (jacobian.determinant() <= 0 || jacobian.trace() <= 0) return std::nullopt;
    p = distorted;
  }
  return Eigen::Vector2d(fx * p.x() + cx, fy * p.y() + cy);
}

std::optional<Eigen::Vector3d> Camera::ray(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (lens == LensModel::kFisheye) {
    const double target = distorted.norm();
    double theta = target;
    for (int i = 0; i < kNewtonSteps; ++i) {
      double slope = 1;
      const double error = distort_angle(distortion, theta, &slope) - target;
      if (slope <= 0) return std::nullopt;
      theta -= error / slope;
      if (std::abs(error) < 1e-14) break;
    }
    if (!(theta >= 0) || theta > M_PI || std::abs(distort_angle(distortion, theta, nullptr) - target) > 1e-10)
      return std::nullopt;
    if (target < 1e-15) return Eigen::Vector3d(0, 0, 1);
    const Eigen::Vector2d side = distorted / target * std::sin(theta);
    return Eigen::Vector3d(side.x(), side.y(), std::cos(theta));
  }
  Eigen::Vector2d p = distorted;
  if (has_distortion()) {
    for (int i = 0; i < kNewtonSteps; ++i) {
      Eigen::Matrix2d jacobian;
      const Eigen::Vector2d error = distort_opencv(distortion, p, &jacobian) - distorted;
      if (jacobian.determinant() <= 0) return std::nullopt;
      p -= jacobian.inverse() * error;
      if (error.squaredNorm() < 1e-28) break;
    }
    Eigen::Matrix2d jacobian;
    const Eigen::Vector2d error = distort_opencv(distortion, p, &jacobian) - distorted;
    if (!(error.norm() < 1e-11) || jacobian.determinant() <= 0 || jacobian.trace() <= 0) return std::nullopt;
  }
  return Eigen::Vector3d(p.x(), p.y(), 1).normalized();
}

Camera Camera::scaled(int new_width, int new_height) const {
  Camera c = *this;
  const double sx = double(new_width) / width, sy = double(new_height) / height;
  c.width = new_width;
  c.height = new_height;
  c.fx *= sx;
  c.fy *= sy;
  c.cx = (cx + 0.5) * sx - 0.5;
  c.cy = (cy + 0.5) * sy - 0.5;
  return c;
}

std::string validation_error(const Camera& camera) {
  constexpr int kMaxSide = 1 << 16;
  if (camera.width < 1 || camera.width > kMaxSide) return "camera.width must be 1.." + std::to_string(kMaxSide);
  if (camera.height < 1 || camera.height > kMaxSide) return "camera.height must be 1.." + std::to_string(kMaxSide);
  // Far beyond any lens, and near enough for what is computed from them to stay finite.
  constexpr double kShortest = 0.001, kLongest = 1e5, kFarthest = 100, kStrongest = 1e6;
  const double side = std::max(camera.width, camera.height);
  const auto is_focal_length = [&](double f) { return f >= kShortest * side && f <= kLongest * side; };
  if (!is_focal_length(camera.fx)) return "camera.fx must be 0.001 to 100000 times the longer side of the image";
  if (!is_focal_length(camera.fy)) return "camera.fy must be 0.001 to 100000 times the longer side of the image";
  for (const double c : {camera.cx, camera.cy})
    if (!(std::abs(c) <= kFarthest * side)) return "camera.cx and camera.cy must be within 100 sides of the image";
  for (const double k : camera.distortion)
    if (!(std::abs(k) <= kStrongest)) return "camera.distortion must be within -1000000..1000000";
  return {};
}

}  // namespace sheen
