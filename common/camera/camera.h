// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

namespace sheen {

enum class LensModel {
  kOpenCv,   ///< distortion = k1 k2 p1 p2 k3 (Brown-Conrady); all zero is a pinhole
  kFisheye,  ///< distortion = k1 k2 k3 k4 of OpenCV's fisheye model (equidistant)
};

/// Intrinsics of a camera. OpenCV axes: x right, y down, z forward; integer pixel coordinates are pixel centres.
struct Camera {
  int width = 0;
  int height = 0;
  double fx = 0, fy = 0;  ///< pixels
  double cx = 0, cy = 0;  ///< pixels
  LensModel lens = LensModel::kOpenCv;
  std::array<double, 5> distortion{};

  bool has_distortion() const;
  bool is_pinhole() const { return lens == LensModel::kOpenCv && !has_distortion(); }  ///< its rays are straight lines

  /// Pixel of a point in camera coordinates, through the lens. Empty behind the camera and where the distortion
  /// polynomial has folded over (no real ray lands there).
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_camera) const;

  /// Unit ray in camera coordinates of a pixel; inverts `project` to 1e-9 px. Empty where the lens has no ray.
  std::optional<Eigen::Vector3d> ray(const Eigen::Vector2d& pixel) const;

  /// Whether the pixel lies inside the image with `margin` pixels to spare on each side.
  bool contains(const Eigen::Vector2d& pixel, double margin = 0) const {
    return pixel.x() >= margin && pixel.y() >= margin && pixel.x() <= width - 1 - margin &&
           pixel.y() <= height - 1 - margin;
  }

  /// The camera of the same view drawn at another size.
  Camera scaled(int new_width, int new_height) const;

  bool operator==(const Camera&) const = default;
};

/// Empty when the camera is usable, else which field is wrong and why.
std::string validation_error(const Camera& camera);

}  // namespace sheen
