// SPDX-License-Identifier: Apache-2.0
#include "common/capture/lighting.h"

#include <algorithm>

namespace sheen {

bool same_light_place(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  constexpr double kRounding = 1e-6;
  return (a - b).norm() <= kRounding * std::max(a.norm(), b.norm());
}

bool same_place(const LightState& a, const LightState& b) {
  if (a.kind != b.kind) return false;
  if (a.kind != LightKind::kDirectional) return same_light_place(a.position, b.position);
  return same_light_place(a.position.normalized(), b.position.normalized());
}

}  // namespace sheen
