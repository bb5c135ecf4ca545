// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>

namespace sheen {

/// A reflectance in plain formulas, to check spacings of lights by: the normal is z.
struct PlainReflectance {
  std::function<double(const Eigen::Vector3d& light, const Eigen::Vector3d& eye)> value;
  /// Whether it is smooth there: no lobe has ended.
  std::function<bool(const Eigen::Vector3d& light, const Eigen::Vector3d& eye)> lit = [](auto&&...) { return true; };
  std::function<Eigen::Vector3d(const Eigen::Vector3d& eye)> highlight = [](const Eigen::Vector3d& eye) {
    return Eigen::Vector3d(-eye.x(), -eye.y(), eye.z());
  };
  double steepest_eye = std::numbers::pi / 2;
};

/// Exposure with a light of intensity 1 at a place; far: of a light in that direction whose irradiance is 1.
inline double plain_exposure(const PlainReflectance& surface, const Eigen::Vector3d& place, const Eigen::Vector3d& eye,
                             bool far) {
  if (place.z() <= 0) return 0;
  const double distance = place.norm();
  return surface.value(place / distance, eye) * (place.z() / distance) / (far ? 1 : distance * distance);
}

/// Surface elements at random under four lights at the corners of a square: those of a plane at a distance of 1 or
/// more, or of a grid of latitude and longitude. Half of them are near the worst: at a highlight, at the least
/// distance.
class LitElements {
 public:
  LitElements(PlainReflectance surface, double spacing, bool far, std::uint64_t seed)
      : surface_(std::move(surface)), spacing_(spacing), far_(far), random_(seed) {}

  struct Worst {
    double lit = 0;       ///< largest error of elements that all lights reach
    double anywhere = 0;  ///< of all, those at the horizon included
    double brightest = 0;
  };
  /// Of bilinear interpolation.
  Worst worst(std::int64_t elements) {
    Worst worst;
    for (std::int64_t i = 0; i < elements; ++i) look_at_next(worst);
    return worst;
  }

 private:
  void look_at_next(Worst& worst) {
    const double spread = std::pow(10, -4 * uniform());
    const Eigen::Vector3d eye = random_eye();
    Eigen::Vector3d light = uniform() < 0.3 ? Eigen::Vector3d(Eigen::Vector3d::UnitZ()) : surface_.highlight(eye);
    light = (light + 3 * spread * direction()).normalized();
    if (light.z() <= 0) return;
    const double a = uniform() < 0.5 ? 0.5 : uniform(), b = uniform() < 0.5 ? 0.5 : uniform();
    const Eigen::Vector3d axis = direction();
    const Eigen::Vector3d up = far_ ? axis : Eigen::Vector3d((light + spread * axis).normalized());
    const Eigen::Vector3d q = up.cross(direction()).normalized(), r = up.cross(q);
    const double height = 1 + (uniform() < 0.5 ? 0 : spread * uniform());
    if (!far_ && light.dot(up) < 0.05) return;
    const auto place = [&](double da, double db) -> Eigen::Vector3d {
      if (!far_) return light * (height / light.dot(up)) + spacing_ * (da * q + db * r);
      const double latitude = std::asin(light.dot(up)) + spacing_ * da,
                   longitude = std::atan2(light.dot(r), light.dot(q)) + spacing_ * db;
      return std::sin(latitude) * up + std::cos(latitude) * (std::cos(longitude) * q + std::sin(longitude) * r);
    };
    double sum = 0;
    bool lit = true;
    for (const double i : {0.0, 1.0})
      for (const double j : {0.0, 1.0}) {
        const Eigen::Vector3d corner = place(i - a, j - b);
        lit = lit && corner.z() > 0 && surface_.lit(corner.normalized(), eye);
        sum += (i > 0 ? a : 1 - a) * (j > 0 ? b : 1 - b) * plain_exposure(surface_, corner, eye, far_);
      }
    const double truth = plain_exposure(surface_, place(0, 0), eye, far_), error = std::abs(sum - truth);
    worst.brightest = std::max(worst.brightest, truth);
    worst.anywhere = std::max(worst.anywhere, error);
    if (lit) worst.lit = std::max(worst.lit, error);
  }
  Eigen::Vector3d random_eye() {
    for (;;) {
      Eigen::Vector3d eye = direction();
      eye.z() = std::abs(eye.z());
      if (eye.z() >= std::cos(surface_.steepest_eye)) return eye;
    }
  }
  double uniform() { return std::uniform_real_distribution<double>()(random_); }
  Eigen::Vector3d direction() {
    const double z = 2 * uniform() - 1, azimuth = 2 * std::numbers::pi * uniform(), s = std::sqrt(1 - z * z);
    return {s * std::cos(azimuth), s * std::sin(azimuth), z};
  }

  PlainReflectance surface_;
  double spacing_;
  bool far_;
  std::mt19937_64 random_;
};

/// Lobes (L.w)^exponent with w where the eye is said to be; exponent 0 is a matt surface.
inline PlainReflectance plain_lobe(double exponent, double matt = 0) {
  return {
      .value = [=](const Eigen::Vector3d& light,
                   const Eigen::Vector3d& axis) { return matt + std::pow(std::max(0.0, light.dot(axis)), exponent); },
      .lit = [=](const Eigen::Vector3d& light,
                 const Eigen::Vector3d& axis) { return exponent == 0 || light.dot(axis) > 0; },
      .highlight = [](const Eigen::Vector3d& axis) { return axis; }};
}

/// A matt part of this albedo under a microfacet lobe (GGX, Smith, Schlick), times pi.
inline PlainReflectance plain_microfacets(double albedo, double normal_reflectance, double roughness) {
  return {.value =
              [=](const Eigen::Vector3d& light, const Eigen::Vector3d& eye) {
                const Eigen::Vector3d half = (light + eye).normalized();
                const double a2 = roughness * roughness, cos2 = half.z() * half.z(), tan2 = (1 - cos2) / cos2;
                const double normals = a2 / (std::numbers::pi * cos2 * cos2 * (a2 + tan2) * (a2 + tan2));
                const auto unmasked = [&](const Eigen::Vector3d& way) {
                  const double t2 = (1 - way.z() * way.z()) / (way.z() * way.z());
                  return 2 / (1 + std::sqrt(1 + a2 * t2));
                };
                const double fresnel =
                    normal_reflectance + (1 - normal_reflectance) * std::pow(1 - light.dot(half), 5.0);
                return albedo + std::numbers::pi * normals * unmasked(light) * unmasked(eye) * fresnel /
                                    (4 * light.z() * eye.z());
              },
          .steepest_eye = 80 * std::numbers::pi / 180};
}

}  // namespace sheen
