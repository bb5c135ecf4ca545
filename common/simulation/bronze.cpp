// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/bronze.h"

#include <algorithm>
#include <cmath>

#include "common/simulation/procedural_noise.h"
#include "common/simulation/texture.h"

namespace sheen {

Material Bronze::operator()(const Eigen::Vector3f& point) const {
  using Color = Eigen::Array3f;
  const Eigen::Vector3f mm = 1000 * point;
  const float marks = gradient_noise(mm / 6), grain = gradient_noise(mm / 1.6f);
  Material metal{.albedo = {0.030f, 0.020f, 0.012f}};
  metal.normal_reflectance = Color(0.74f, 0.54f, 0.29f) * (1 + 0.25f * fractal_noise(mm / 14, 2) + 0.15f * grain);
  metal.roughness = std::clamp(0.22f + 0.08f * marks + 0.04f * grain, 0.13f, 0.34f);

  // Engraved lines stand where a slow noise crosses zero; soot has stayed in them.
  const float line = std::abs(gradient_noise(mm / 13 + Eigen::Vector3f(4, 8, 2)));
  const Material soot{{0.020f, 0.016f, 0.013f}, {0.06f, 0.05f, 0.04f}, 0.45f};
  metal = blend(metal, soot, 0.9f * (1 - smooth_step(0.012f, 0.04f, line)));

  const Material patina{
      Color(0.09f, 0.25f, 0.19f) * (1 + 0.4f * gradient_noise(mm / 1.3f)), {0.03f, 0.03f, 0.03f}, 0.5f};
  Material bronze = blend(metal, patina, smooth_step(0.16f, 0.24f, fractal_noise(mm / 11, 3)));
  bronze.normal_reflectance = bronze.normal_reflectance.max(0.02f).min(0.95f);
  return bronze;
}

}  // namespace sheen
