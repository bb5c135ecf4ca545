// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/studio_lighting.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/angle.h"

namespace sheen {
namespace {

float smooth_step(float from, float to, float x) {
  const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

/// A softbox at infinity: a rounded rectangle on the sphere of directions, with soft edges.
struct FarSoftbox {
  Eigen::Vector3f forward, right, up;
  float half_width, half_height, edge;  // tangents of angles
  Eigen::Array3f radiance;

  FarSoftbox(float azimuth_deg, float elevation_deg, float half_width_deg, float half_height_deg, float edge_deg,
             Eigen::Array3f radiance_)
      : radiance(radiance_) {
    const float a = azimuth_deg * float(kDegree), e = elevation_deg * float(kDegree);
    forward = {std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e)};
    right = forward.cross(Eigen::Vector3f::UnitZ()).normalized();
    up = right.cross(forward);
    half_width = std::tan(half_width_deg * float(kDegree));
    half_height = std::tan(half_height_deg * float(kDegree));
    edge = std::tan(edge_deg * float(kDegree));
  }
  Eigen::Array3f operator()(const Eigen::Vector3f& d) const {
    const float depth = d.dot(forward);
    if (depth <= 0.1f) return Eigen::Array3f::Zero();
    const float x = std::abs(d.dot(right)) / depth, y = std::abs(d.dot(up)) / depth;
    return radiance * ((1 - smooth_step(half_width - edge, half_width + edge, x)) *
                       (1 - smooth_step(half_height - edge, half_height + edge, y)));
  }
};

Eigen::Array3f studio_environment(const Eigen::Vector3f& d) {
  static const std::array boxes{
      FarSoftbox(125, 48, 20, 13, 6, {2.6f, 2.7f, 2.9f}),
      FarSoftbox(20, 30, 8, 24, 5, {2.2f, 1.9f, 1.5f}),
      FarSoftbox(-60, 68, 12, 12, 6, {2.2f, 2.2f, 2.2f}),
  };
  const Eigen::Array3f ceiling(0.50f, 0.53f, 0.58f), wall(0.30f, 0.29f, 0.28f), floor(0.06f, 0.055f, 0.05f);
  Eigen::Array3f radiance = wall + (ceiling - wall) * smooth_step(0.05f, 0.9f, d.z());
  radiance = floor + (radiance - floor) * smooth_step(-0.25f, 0.05f, d.z());
  for (const FarSoftbox& box : boxes) radiance += box(d);
  return radiance;
}

}  // namespace

Eigen::Vector3f AreaLight::normal() const {
  return half_u.cross(half_v).normalized();
}

float AreaLight::area() const {
  return 4 * half_u.cross(half_v).norm();
}

float AreaLight::profile(float a, float b) const {
  if (std::max(std::abs(a), std::abs(b)) > 1) return 0;
  if (falloff <= 0) return 1;
  return (1 - smooth_step(1 - falloff, 1, std::abs(a))) * (1 - smooth_step(1 - falloff, 1, std::abs(b)));
}

std::optional<AreaLight::Crossing> AreaLight::meet(const Eigen::Vector3f& origin,
                                                   const Eigen::Vector3f& direction) const {
  const Eigen::Vector3f n = normal();
  const float slope = direction.dot(n);
  if (slope >= 0) return std::nullopt;
  const float distance = (centre - origin).dot(n) / slope;
  if (distance <= 0) return std::nullopt;
  const Eigen::Vector3f at = origin + distance * direction - centre;
  const float emission = profile(at.dot(half_u) / half_u.squaredNorm(), at.dot(half_v) / half_v.squaredNorm());
  if (emission <= 0) return std::nullopt;
  return Crossing{distance, emission};
}

StudioLighting make_studio() {
  AreaLight light;
  light.centre = {-0.42f, -0.50f, 0.78f};
  const Eigen::Vector3f shine = (Eigen::Vector3f(0, 0, 0.05f) - light.centre).normalized();
  light.half_u = 0.20f * shine.cross(Eigen::Vector3f::UnitZ()).normalized();
  light.half_v = 0.15f * shine.cross(light.half_u).normalized();
  light.radiance = {9.0f, 8.5f, 7.6f};
  light.falloff = 0.55f;
  return {studio_environment, light};
}

StudioLighting make_uniform_lighting(const Eigen::Array3f& radiance) {
  return {[radiance](const Eigen::Vector3f&) { return radiance; }, std::nullopt};
}

}  // namespace sheen
