// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "common/image/color.h"

/// Pictures with exact truth: a sphere or square whose radiance is a closed form of place and direction, evaluated a
/// pixel by solving for the surface. Shares only the camera's lens with what it tests; casts no ray at a mesh.
namespace sheen::analytic {

/// Distance along a unit ray to the surface's front side; infinity where the ray misses.
using Surface = std::function<double(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray)>;
/// Linear RGB radiance that leaves `point` in the unit direction `to_eye`.
using Radiance = std::function<Eigen::Vector3d(const Eigen::Vector3d& point, const Eigen::Vector3d& to_eye)>;

inline constexpr double kMiss = std::numeric_limits<double>::infinity();

/// Round the origin.
inline Surface sphere(double radius) {
  return [radius](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
    const double along = -eye.dot(ray);
    const double rest = radius * radius - (eye + along * ray).squaredNorm();
    const double t = along - std::sqrt(std::max(rest, 0.0));
    return rest >= 0 && t > 0 ? t : kMiss;
  };
}

/// Side 2 * half round (0, 0, z), facing +z.
inline Surface square(double half, double z) {
  return [half, z](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
    if (!(ray.z() < 0)) return kMiss;
    const double t = (z - eye.z()) / ray.z();
    const Eigen::Vector3d p = eye + t * ray;
    return t > 0 && std::abs(p.x()) <= half && std::abs(p.y()) <= half ? t : kMiss;
  };
}

inline Surface nearest_of(Surface a, Surface b) {
  return [a = std::move(a), b = std::move(b)](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
    return std::min(a(eye, ray), b(eye, ray));
  };
}

/// A radiance given by its sRGB-encoded values, in which the light field is factorized.
inline Radiance encoded(std::function<Eigen::Vector3d(const Eigen::Vector3d&, const Eigen::Vector3d&)> value) {
  return [value = std::move(value)](const Eigen::Vector3d& point, const Eigen::Vector3d& to_eye) {
    const Eigen::Vector3d e = value(point, to_eye);
    return Eigen::Vector3d(e.unaryExpr([](double v) { return double(srgb_decode(static_cast<float>(v))); }));
  };
}

/// Smooth colours between 0.2 and 0.8 (encoded) whose waves are `length` metres long.
inline Eigen::Vector3d waves(const Eigen::Vector3d& p, double length) {
  const double k = 2 * M_PI / length;
  return {0.5 + 0.15 * std::sin(k * p.x()) + 0.15 * std::cos(k * p.y()),
          0.5 + 0.15 * std::sin(k * p.y() + 1) + 0.15 * std::cos(k * p.z()),
          0.5 + 0.15 * std::cos(k * p.z()) + 0.15 * std::sin(k * (p.x() + p.y()))};
}

/// The same from everywhere.
inline Radiance diffuse(double wave_length) {
  return encoded([wave_length](const Eigen::Vector3d& p, const Eigen::Vector3d&) { return waves(p, wave_length); });
}

/// Two terms exactly (encoded): a texture, and another one that grows with the direction's x.
inline Radiance two_terms(double wave_length) {
  return encoded([wave_length](const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
    const Eigen::Vector3d swapped(p.y(), p.z(), p.x());
    return Eigen::Vector3d(0.8 * waves(p, wave_length) + 0.5 * d.x() * waves(swapped, 0.8 * wave_length));
  });
}

struct Scene {
  Surface surface;
  Radiance radiance;
  Eigen::Vector3d background{5, 0, 5};  ///< glaring, so that any of it that bleeds into the object is noticed
};

/// Linear RGB, a point sample at each pixel's centre.
inline ImageF picture(const Scene& scene, const Camera& camera, const Rigid3& camera_from_object) {
  const Rigid3 object_from_camera = camera_from_object.inverse();
  const Eigen::Vector3d eye = object_from_camera.translation;
  ImageF image(camera.width, camera.height, 3);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      Eigen::Vector3d rgb = scene.background;
      if (const auto ray = camera.ray({double(x), double(y)})) {
        const Eigen::Vector3d direction = object_from_camera.rotation * *ray;
        const double t = scene.surface(eye, direction);
        if (t < kMiss) rgb = scene.radiance(eye + t * direction, -direction);
      }
      Eigen::Map<Eigen::Vector3f>(image.pixel(x, y)) = rgb.cast<float>();
    }
  return image;
}

inline RawImage float_image(const ImageF& linear) {
  RawImage raw{.format = PixelFormat::kRGB32f, .transfer = Transfer::kLinear};
  raw.width = linear.width();
  raw.height = linear.height();
  raw.stride = std::size_t(12) * linear.width();
  raw.bytes.resize(raw.stride * linear.height());
  std::memcpy(raw.bytes.data(), linear.data(), raw.bytes.size());
  return raw;
}

inline Capture capture(const Scene& scene, const Camera& camera, const Rigid3& camera_from_object) {
  Capture c;
  c.source_session = "analytic";
  c.camera = camera;
  c.image = float_image(picture(scene, camera, camera_from_object));
  c.exposure.locked = true;
  c.pose.status = PoseStatus::kGiven;
  c.pose.camera_from_object = camera_from_object;
  return c;
}

/// Eyes spread evenly over the part of a sphere of this radius that lies above z = lowest * radius, by the golden
/// angle.
inline std::vector<Eigen::Vector3d> eyes(int count, double radius, double lowest, double highest = 0.98) {
  std::vector<Eigen::Vector3d> result;
  for (int i = 0; i < count; ++i) {
    const double z = lowest + (highest - lowest) * (i + 0.5) / count, angle = i * M_PI * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    result.emplace_back(radius * r * std::cos(angle), radius * r * std::sin(angle), radius * z);
  }
  // Neighbours in time should not be neighbours in height: a fixed stride through the list that visits all of it.
  std::vector<Eigen::Vector3d> mixed;
  int step = static_cast<int>(0.618 * count) | 1;
  while (std::gcd(step, count) != 1) step += 2;
  for (int i = 0; i < count; ++i) mixed.push_back(result[std::size_t(i) * step % count]);
  return mixed;
}

inline Rigid3 towards_origin(const Eigen::Vector3d& eye) {
  return look_at(eye, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ());
}

}  // namespace sheen::analytic
