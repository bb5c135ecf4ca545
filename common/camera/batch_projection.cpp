// SPDX-License-Identifier: Apache-2.0
#include "common/camera/batch_projection.h"

#include <limits>

namespace sheen {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Brown-Conrady without a branch, so that the loop is vectorised.
void project_opencv(const Camera& camera, std::size_t n, const float* __restrict x, const float* __restrict y,
                    const float* __restrict z, float* __restrict pixel_x, float* __restrict pixel_y) {
  float k[5];
  for (int i = 0; i < 5; ++i) k[i] = static_cast<float>(camera.distortion[i]);
  const float k1 = k[0], k2 = k[1], p1 = k[2], p2 = k[3], k3 = k[4];
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  for (std::size_t i = 0; i < n; ++i) {
    const float inverse = 1 / z[i];
    const float u = x[i] * inverse, v = y[i] * inverse;
    const float uu = u * u, vv = v * v, uv = u * v, r2 = uu + vv;
    const float radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const float slope = k1 + r2 * (2 * k2 + r2 * 3 * k3);  // d radial / d r2
    const float du = u * radial + 2 * p1 * uv + p2 * (r2 + 2 * uu);
    const float dv = v * radial + p1 * (r2 + 2 * vv) + 2 * p2 * uv;
    // Jacobian of the lens: past the fold, where it turns over, no real ray lands.
    const float j00 = radial + 2 * uu * slope + 2 * p1 * v + 6 * p2 * u;
    const float j11 = radial + 2 * vv * slope + 6 * p1 * v + 2 * p2 * u;
    const float j01 = 2 * uv * slope + 2 * p1 * u + 2 * p2 * v;
    const bool real = (z[i] > 1e-9f) & (j00 * j11 > j01 * j01) & (j00 + j11 > 0);
    pixel_x[i] = real ? fx * du + cx : kNone;
    pixel_y[i] = real ? fy * dv + cy : kNone;
  }
}

}  // namespace

void project(const Camera& camera, std::span<const float> x, std::span<const float> y, std::span<const float> z,
             std::span<float> pixel_x, std::span<float> pixel_y) {
  if (camera.lens == LensModel::kOpenCv)
    return project_opencv(camera, x.size(), x.data(), y.data(), z.data(), pixel_x.data(), pixel_y.data());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto pixel = camera.project({x[i], y[i], z[i]});
    pixel_x[i] = pixel ? static_cast<float>(pixel->x()) : kNone;
    pixel_y[i] = pixel ? static_cast<float>(pixel->y()) : kNone;
  }
}

}  // namespace sheen
