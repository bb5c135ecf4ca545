// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/lacquer.h"

#include <algorithm>
#include <cmath>

#include "common/simulation/procedural_noise.h"
#include "common/simulation/texture.h"

namespace sheen {
namespace {

constexpr float kFoot = 0.009f, kTop = 0.106f;        // metres
constexpr float kBands[]{0.019f, 0.0806f, 0.107f};    // heights
constexpr float kHalfBand = 1.6f, kBandEdge = 0.35f;  // mm

}  // namespace

Material Lacquer::operator()(const Eigen::Vector3f& point) const {
  using Color = Eigen::Array3f;
  const Eigen::Vector3f mm = 1000 * point;
  const float height = (point.z() - kFoot) / (kTop - kFoot) + 0.30f * fractal_noise(mm / 30, 2);
  const Color red(0.50f, 0.052f, 0.030f), black(0.06f, 0.018f, 0.034f);
  Material lacquer{.normal_reflectance = {0.10f, 0.10f, 0.10f}, .roughness = 0.10f};
  const float blackness = smooth_step(0.25f, 0.75f, height);
  lacquer.albedo = blend(red, black, blackness) * (1 + 0.25f * fractal_noise(mm / 6, 2));
  lacquer.roughness += 0.01f * gradient_noise(mm / 19);

  const Material gold{{0.16f, 0.09f, 0.02f}, {0.50f, 0.35f, 0.14f}, 0.17f};
  const ScatteredPoint dust = nearest_scattered_point(mm / 2.6f);
  const float radius = 0.08f + 0.22f * dust.name, meeting = 4 * blackness * (1 - blackness);
  const float grain = 1 - smooth_step(radius - 0.08f, radius + 0.08f, dust.distance);
  float gilding = grain * smooth_step(0.25f, 0.7f, meeting);
  for (const float band : kBands)
    gilding = std::max(gilding,
                       1 - smooth_step(kHalfBand - kBandEdge, kHalfBand + kBandEdge, std::abs(mm.z() - 1000 * band)));
  return blend(lacquer, gold, gilding);
}

}  // namespace sheen
