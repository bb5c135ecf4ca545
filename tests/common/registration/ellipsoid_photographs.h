// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "common/registration/registration_image.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/test_meshes.h"

namespace sheen {

inline const Camera kCamera{.width = 240, .height = 200, .fx = 420, .fy = 420, .cx = 119.5, .cy = 99.5};
inline constexpr double kDistance = 0.5, kPixel = kDistance / 420;  // on the object, metres
inline const Eigen::Vector3d kAxes(0.10, 0.075, 0.055);             // of the ellipsoid, metres

/// Pictures are of a closed form; only the mesh that is registered is one.
inline analytic::Surface ellipsoid(const Eigen::Vector3d& axes = kAxes,
                                   const Eigen::Vector3d& middle = Eigen::Vector3d::Zero()) {
  return [axes, middle](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
    const Eigen::Vector3d e = (eye - middle).cwiseQuotient(axes), r = ray.cwiseQuotient(axes);
    const double a = r.squaredNorm(), b = e.dot(r), c = e.squaredNorm() - 1;
    return b * b > a * c && b < 0 ? (-b - std::sqrt(b * b - a * c)) / a : analytic::kMiss;
  };
}

inline Mesh ellipsoid_mesh(const Eigen::Vector3d& axes = kAxes, const Eigen::Vector3d& middle = Eigen::Vector3d::Zero(),
                           int fineness = 5) {
  Mesh mesh = sphere_mesh(1, fineness);
  for (Eigen::Vector3f& v : mesh.vertices) v = v.cwiseProduct(axes.cast<float>()) + middle.cast<float>();
  return mesh;
}

inline RegistrationImage photograph(const analytic::Scene& scene, const Eigen::Vector3d& eye, bool masked) {
  Capture capture = analytic::capture(scene, kCamera, analytic::towards_origin(eye));
  if (masked) {
    const Rigid3 object_from_camera = capture.pose.camera_from_object.inverse();
    capture.mask = ImageU8(kCamera.width, kCamera.height, 1);
    for (int y = 0; y < kCamera.height; ++y)
      for (int x = 0; x < kCamera.width; ++x) {
        const Eigen::Vector3d ray = object_from_camera.rotation * *kCamera.ray({double(x), double(y)});
        capture.mask.at(x, y) = scene.surface(object_from_camera.translation, ray) < analytic::kMiss ? 255 : 0;
      }
  }
  return registration_image(capture);
}

/// As a hand-held camera takes images one after the other, 12 degrees apart, beginning at an azimuth (rad).
inline std::vector<RegistrationImage> images_in_turn(const analytic::Scene& scene, bool masks, std::size_t count,
                                                     double azimuth = 0) {
  std::vector<RegistrationImage> images;
  for (std::size_t i = 0; i < count; ++i, azimuth += 0.2)
    images.push_back(
        photograph(scene, kDistance * Eigen::Vector3d(0.8 * std::cos(azimuth), 0.8 * std::sin(azimuth), 0.6), masks));
  return images;
}

}  // namespace sheen
