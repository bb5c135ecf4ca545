// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/radiance/light_refusal.h"

namespace sheen {

std::string light_refusal(const LightState& light, LightKind kind) {
  if (light.kind != LightKind::kDirectional && light.kind != LightKind::kPoint) return "no_light_position";
  if (light.kind != kind) return "other_kind_of_light";
  if (!light.position.allFinite() || !light.rgb.allFinite() || !(light.rgb.minCoeff() > 0)) return "broken_light";
  if (kind == LightKind::kDirectional && !(light.position.norm() > 0)) return "broken_light";
  return {};
}

}  // namespace sheen
