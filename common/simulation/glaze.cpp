// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/glaze.h"

#include <algorithm>
#include <cmath>

#include "common/simulation/procedural_noise.h"
#include "common/simulation/texture.h"

namespace sheen {
namespace {

/// 1 on the spots, `rim` 1 on the ring round them; lengths in units of the scattered points' cells.
struct Spots {
  float inside, rim;
};
Spots spots(const Eigen::Vector3f& p, float smallest, float largest, float edge) {
  const ScatteredPoint point = nearest_scattered_point(p);
  const float radius = smallest + (largest - smallest) * point.name;
  const float inside = 1 - smooth_step(radius - edge, radius + edge, point.distance);
  const float outer = radius + 2.5f * edge;
  return {inside, (1 - smooth_step(outer - edge, outer + edge, point.distance)) * (1 - inside)};
}

}  // namespace

Material Glaze::operator()(const Eigen::Vector3f& point) const {
  using Color = Eigen::Array3f;
  const Eigen::Vector3f mm = 1000 * point;
  const float warp = fractal_noise(mm / 28, 3);
  const float height = std::clamp((point.z() - foot_height) / (top_height - foot_height), 0.0f, 1.0f);

  // Colour runs down the body: noise that is much longer along z than across.
  const float runs = fractal_noise(Eigen::Vector3f(mm.x() / 7, mm.y() / 7, mm.z() / 45), 2);
  const float depth = std::clamp(height + 0.45f * warp + 0.30f * runs, 0.0f, 1.0f);
  const Color sand(0.46f, 0.30f, 0.15f), turquoise(0.06f, 0.34f, 0.33f), cobalt(0.020f, 0.065f, 0.22f);
  Color color = depth < 0.4f ? blend(sand, turquoise, smooth_step(0, 0.4f, depth))
                             : blend(turquoise, cobalt, smooth_step(0.4f, 0.95f, depth));
  color *= 1 + 0.35f * gradient_noise(mm / 2.2f) + 0.2f * gradient_noise(mm / 1.1f);

  Material glaze;
  glaze.roughness = 0.215f + 0.13f * gradient_noise(mm / 17 + Eigen::Vector3f(5, 1, 9));
  glaze.roughness = std::clamp(glaze.roughness, 0.14f, 0.29f);
  const float lustre = 0.5f + 0.5f * std::clamp(1.6f * gradient_noise(mm / 21), -1.0f, 1.0f);
  glaze.normal_reflectance = blend(Color(0.08f, 0.08f, 0.085f), Color(0.20f, 0.18f, 0.16f), lustre);

  const Spots cream = spots(mm / 6.5f, 0.10f, 0.30f, 0.035f);
  color = blend(color, Color(0.72f, 0.64f, 0.48f), 0.92f * cream.inside);
  color = blend(color, Color(0.035f, 0.022f, 0.016f), 0.85f * cream.rim);
  const Spots speckle = spots(mm / 2.4f + Eigen::Vector3f(3, 7, 1), 0.02f, 0.24f, 0.07f);
  color = blend(color, Color(0.05f, 0.035f, 0.025f), 0.6f * speckle.inside * (1 - cream.inside));

  // Hairline cracks stand where a slow noise crosses zero.
  const float crack = std::abs(gradient_noise(mm / 9 + Eigen::Vector3f(11, 3, 2)));
  color *= 1 - 0.45f * (1 - smooth_step(0.015f, 0.06f, crack));
  glaze.albedo = color.max(0.01f).min(0.85f);

  const Material gold{{0.10f, 0.055f, 0.015f}, {0.52f, 0.36f, 0.15f}, 0.25f};
  const float wave = 0.0016f * gradient_noise(mm / 24) + 0.0008f * std::sin(12 * std::atan2(point.y(), point.x()));
  float gilding = 0;
  for (int i = 0; i < 3; ++i) {
    const float off = std::abs(point.z() - band_heights[i] - wave) * 1000;
    gilding = std::max(gilding, 1 - smooth_step(1.5f, 1.9f, off));
    const float line = std::abs(off - 3.3f);
    gilding = std::max(gilding, 1 - smooth_step(0.35f, 0.7f, line));
  }
  const float wear = smooth_step(-0.25f, 0.05f, fractal_noise(mm / 3.5f, 2));  // gold leaf that has worn off in places
  Material result = blend(glaze, gold, gilding * (0.35f + 0.65f * wear));

  const Material clay{Color(0.42f, 0.27f, 0.18f) * (1 + 0.5f * fractal_noise(mm / 2, 3)), {0.03f, 0.03f, 0.03f}, 0.5f};
  const float bare = 1 - smooth_step(-0.0006f, 0.0006f, point.z() - foot_height - 0.002f * warp);
  return blend(result, clay, bare);
}

}  // namespace sheen
