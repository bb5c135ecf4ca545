// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/irradiance_field_file/field_lights.h"

#include <cmath>
#include <string>

#include "common/base/errors.h"
#include "reconstructor/radiance/light_refusal.h"

namespace sheen {
namespace {

/// Between lights the absolute weights add up to 3 at most; what lies beyond them is a difference of ever larger ones.
constexpr float kMostWeight = 4;

constexpr double kOnPlane = 1e-4;  // of its distance: nearer than that a lamp is on its plane

/// The nearer a light, the more it counts; none less than nothing.
Eigen::VectorXf weights_by_distance(const Eigen::Matrix3Xd& lights, const Eigen::Vector3d& place) {
  const Eigen::VectorXd weights = (lights.colwise() - place).colwise().squaredNorm().cwiseInverse().transpose();
  return (weights / weights.sum()).cast<float>();
}

}  // namespace

FieldLights::FieldLights(const LitScene& scene)
    : kind_(scene.kind), lights_(scene.lights), kriging_(scene.lights, scene.kernel), plane_(light_plane(scene)) {}

LightState FieldLights::known(const LightState& light) const {
  if (light.kind == LightKind::kFixed) return light;
  LightState known = light;
  const bool far = light.kind == LightKind::kDirectional;
  const std::string wrong = light_refusal(light, far ? LightKind::kDirectional : LightKind::kPoint);
  const auto met = plane_ && wrong.empty() ? plane_->meet(light.position) : std::nullopt;
  if (met) {
    // Lamps on the plane keep their brightness to the last bit.
    const double off = std::abs(plane_->normal.dot(light.position) - plane_->distance);
    if (!far && off <= kOnPlane * plane_->distance) return light;
    const double reference = far ? plane_->distance : light.position.norm();
    known.kind = LightKind::kPoint;
    known.position = *met;
    known.rgb *= static_cast<float>(met->squaredNorm() / (reference * reference));
    return known;
  }
  if (!wrong.empty() || light.kind != kind_)
    throw ConfigError(
        kind_ == LightKind::kDirectional
            ? "this irradiance field was built in directional light: give directions, not positions"
            : "this irradiance field was built in the light of near lamps: give positions, not directions");
  if (far) known.position.normalize();
  return known;
}

Eigen::VectorXf FieldLights::weights(const LightState& light) const {
  if (light.kind == LightKind::kFixed)
    return Eigen::VectorXf::Constant(lights_.cols(), 1.0f / static_cast<float>(lights_.cols()));
  const Eigen::VectorXf kriged = kriging_.weights(light.position);
  const float sum = kriged.cwiseAbs().sum();
  if (sum <= kMostWeight) return kriged;
  const float part = kMostWeight / sum;
  return part * kriged + (1 - part) * weights_by_distance(lights_, light.position);
}

}  // namespace sheen
