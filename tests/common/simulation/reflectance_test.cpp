// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/reflectance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace sheen {
namespace {

using Eigen::Array3f;
using Eigen::Vector3f;

Material lobe(float alpha, float f0) {
  return {.albedo = Array3f::Zero(), .normal_reflectance = Array3f::Constant(f0), .roughness = alpha};
}

Vector3f eye_at(float cosine) {
  return {std::sqrt(1 - cosine * cosine), 0, cosine};
}

/// Integral of brdf * cosine * radiance over the hemisphere by a plain midpoint rule.
double reflected(const Material& m, const Vector3f& eye, const std::function<double(const Vector3f&)>& radiance) {
  constexpr int kRings = 600, kSpokes = 1200;
  double sum = 0;
  for (int i = 0; i < kRings; ++i)
    for (int j = 0; j < kSpokes; ++j) {
      const double z = (i + 0.5) / kRings, r = std::sqrt(1 - z * z), phi = 2 * M_PI * (j + 0.5) / kSpokes;
      const Vector3f light(float(r * std::cos(phi)), float(r * std::sin(phi)), float(z));
      sum += ggx(m, eye, light)[0] * z * radiance(light);
    }
  return sum * 2 * M_PI / (kRings * kSpokes);
}

TEST(Ggx, ReflectsNoMoreThanArrives) {
  for (const float alpha : {0.15f, 0.3f, 0.6f, 1.0f})
    for (const float cosine : {0.1f, 0.4f, 0.8f, 1.0f}) {
      const double albedo = reflected(lobe(alpha, 1), eye_at(cosine), [](const Vector3f&) { return 1.0; });
      EXPECT_LE(albedo, 1.002) << alpha << ' ' << cosine;
      EXPECT_GT(albedo, 0.25) << "what bounces twice among microfacets is not counted";
    }
}

TEST(Ggx, IsReciprocal) {
  const Material m = lobe(0.22f, 0.1f);
  const Vector3f a = Vector3f(0.3f, -0.5f, 0.6f).normalized(), b = Vector3f(-0.7f, 0.2f, 0.4f).normalized();
  EXPECT_NEAR(ggx(m, a, b)[0], ggx(m, b, a)[0], 1e-5f * ggx(m, a, b)[0]);
  EXPECT_EQ(ggx(m, a, -b)[0], 0) << "nothing comes from below";
}

TEST(Ggx, TheAlbedoTableAgreesWithQuadrature) {
  for (const float alpha : {0.17f, 0.3f, 0.55f})
    for (const float f0 : {0.04f, 0.5f})
      for (const float cosine : {0.15f, 0.5f, 0.95f}) {
        const double exact = reflected(lobe(alpha, f0), eye_at(cosine), [](const Vector3f&) { return 1.0; });
        EXPECT_NEAR(lobe_albedo(lobe(alpha, f0), cosine)[0], exact, 0.012) << alpha << ' ' << f0 << ' ' << cosine;
      }
}

TEST(Ggx, SamplingEstimatesTheIntegral) {
  const auto radiance = [](const Vector3f& l) { return 1 + l.x() + 2 * l.y() * l.y(); };
  for (const float cosine : {0.3f, 0.9f}) {
    const Material m = lobe(0.25f, 0.2f);
    constexpr int kSide = 400;
    double sum = 0;
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; j += LobePoints::kCount) {
        LobePoints points;
        for (int k = 0; k < LobePoints::kCount; ++k) points.add((i + 0.5f) / kSide, (j + k + 0.5f) / kSide);
        const LobeSamples s = sample_ggx(m.roughness, eye_at(cosine), points);
        for (int k = 0; k < LobePoints::kCount; ++k) {
          const Vector3f light(s.x[k], s.y[k], s.z[k]);
          EXPECT_NEAR(light.norm(), 1, 1e-4);
          sum += (m.normal_reflectance[0] * s.scale[k] + s.bias[k]) * radiance(light);
        }
      }
    const double exact = reflected(m, eye_at(cosine), radiance);
    EXPECT_NEAR(sum / (kSide * kSide), exact, 0.01 * exact) << cosine;
  }
}

TEST(Ggx, TheMeanAlbedoIsTheCosineWeightedOne) {
  const Material m = lobe(0.25f, 0.1f);
  double sum = 0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const double c = (i + 0.5) / kSteps;
    sum += 2 * c * lobe_albedo(m, float(c))[0] / kSteps;
  }
  EXPECT_NEAR(mean_lobe_albedo(m)[0], sum, 2e-3);
}

TEST(Fresnel, GoesFromNormalReflectanceToOne) {
  EXPECT_FLOAT_EQ(fresnel(Array3f::Constant(0.04f), 1)[0], 0.04f);
  EXPECT_FLOAT_EQ(fresnel(Array3f::Constant(0.04f), 0)[0], 1);
}

}  // namespace
}  // namespace sheen
