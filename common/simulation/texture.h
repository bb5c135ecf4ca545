// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "common/simulation/reflectance.h"

namespace sheen {

// What the generated materials are mixed from.

inline float smooth_step(float from, float to, float x) {
  const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

inline Eigen::Array3f blend(const Eigen::Array3f& a, const Eigen::Array3f& b, float t) {
  return a + (b - a) * t;
}

inline Material blend(const Material& a, const Material& b, float t) {
  return {blend(a.albedo, b.albedo, t), blend(a.normal_reflectance, b.normal_reflectance, t),
          a.roughness + (b.roughness - a.roughness) * t};
}

}  // namespace sheen
