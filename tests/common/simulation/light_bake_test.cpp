// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/light_bake.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/simulation/path_tracer.h"

namespace sheen {
namespace {

using Eigen::Array3f;
using Eigen::Vector3f;

Material matt(float albedo) {
  return {.albedo = Array3f::Constant(albedo), .normal_reflectance = Array3f::Zero(), .roughness = 0.5f};
}

constexpr BakeOptions kCoarse{.sky_directions = 512, .bounce_directions = 256, .bounces = 2};

/// Radiance of the object from many sides; nothing where a ray misses it.
std::vector<Array3f> seen_from_around(const PathTracer& tracer, int lobe_samples) {
  std::vector<Array3f> radiance;
  const Mesh& mesh = tracer.scene().object.mesh;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 97) {
    const Vector3f centre = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
    const Vector3f out = mesh.area_normal(t).normalized();
    const Vector3f slanted = (out + 0.7f * Vector3f(out.y(), -out.x(), 0.3f)).normalized();
    radiance.push_back(tracer.radiance(centre + 0.001f * slanted, -slanted, lobe_samples));
  }
  return radiance;
}

TEST(Furnace, AWhiteObjectOfAnyShapeIsInvisible) {
  TestObject object = make_demo_object();  // handle, spout and foot: interreflection must give back what is hidden
  object.material = [](const Vector3f&) { return matt(1); };
  const PathTracer tracer({object, std::nullopt, make_uniform_lighting(Array3f::Ones())},
                          {.sky_directions = 256, .bounce_directions = 128, .bounces = 12});
  double sum = 0;
  const auto radiance = seen_from_around(tracer, 0);
  for (const Array3f& r : radiance) {
    EXPECT_NEAR(r[0], 1, 0.08);
    sum += r[0];
  }
  EXPECT_NEAR(sum / radiance.size(), 1, 0.01);
}

TEST(Furnace, AGlossyWhiteSphereIsInvisibleToo) {
  const Material glossy{.albedo = Array3f::Ones(), .normal_reflectance = Array3f::Constant(0.15f), .roughness = 0.2f};
  const PathTracer tracer(
      {make_sphere(glossy, 0.05, {0, 0, 0.05}, 3), std::nullopt, make_uniform_lighting(Array3f::Ones())}, kCoarse);
  for (const Array3f& r : seen_from_around(tracer, 1024)) EXPECT_NEAR(r[0], 1, 0.02);
}

TEST(Furnace, GreyReflectsItsAlbedo) {
  const PathTracer tracer(
      {make_sphere(matt(0.37f), 0.05, {0, 0, 0.05}, 3), std::nullopt, make_uniform_lighting({1, 2, 3})}, kCoarse);
  for (const Array3f& r : seen_from_around(tracer, 0))
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(r[c], 0.37 * (c + 1), 3e-3);
}

TEST(LambertianSphere, MatchesTheIrradianceOfALinearSky) {
  // Radiance 1 + d.z gives pi + 2 pi / 3 n.z (Ramamoorthi and Hanrahan 2001).
  StudioLighting sky{[](const Vector3f& d) -> Array3f { return Array3f::Constant(1 + d.z()); }, std::nullopt};
  const PathTracer tracer({make_sphere(matt(0.8f), 0.05, {0, 0, 0}, 3), std::nullopt, sky}, kCoarse);
  const Mesh& mesh = tracer.scene().object.mesh;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 13) {
    const Hit hit{.triangle = std::uint32_t(t), .distance = 0, .u = 1.0f / 3, .v = 1.0f / 3, .front = true};
    const double nz = mesh.area_normal(t).normalized().z();
    EXPECT_NEAR(tracer.light().object_irradiance(hit)[1], M_PI + 2 * M_PI / 3 * nz, 0.03);
  }
}

/// A square light over the stage's middle and a small dark ball at `ball`.
PathTracer lit_stage(const Eigen::Vector3d& ball, double ball_radius, float half_side, float height) {
  AreaLight light;
  light.centre = {0, 0, height};
  light.half_u = {half_side, 0, 0};
  light.half_v = {0, -half_side, 0};
  light.radiance = {5, 5, 5};
  StudioLighting lighting = make_uniform_lighting(Array3f::Zero());
  lighting.area_light = light;
  return PathTracer({make_sphere(matt(0), ball_radius, ball, 3), StageSurface(make_stage({})), lighting},
                    {.sky_directions = 64, .bounce_directions = 64, .bounces = 0});
}

TEST(AreaLight, MatchesTheFormFactorOfARectangle) {
  const float half = 0.2f, height = 0.5f;
  const PathTracer tracer = lit_stage({0.4, 0, 0.02}, 0.01, half, height);
  ASSERT_LT(tracer.scene().lighting.area_light->normal().z(), -0.99f) << "it shines down";
  // A differential element under the centre of a parallel rectangle: four times that under a corner.
  const double x = half / height, s = std::sqrt(1 + x * x);
  const double factor = 4 / (2 * M_PI) * (2 * x / s * std::atan(x / s));
  const double exact = M_PI * 5 * factor;
  EXPECT_NEAR(tracer.light().stage_irradiance(0, 0)[0], exact, 0.005 * exact);
}

TEST(AreaLight, ABallCastsItsShadow) {
  const PathTracer tracer = lit_stage({0, 0, 0.04}, 0.03, 0.002f, 0.5f);
  // Seen from a point-like light 0.5 m up, the ball 0.46 m below it covers a disc of radius 0.5 tan(asin(0.03 / 0.46)).
  const double edge = 0.5 * std::tan(std::asin(0.03 / 0.46));
  EXPECT_EQ(tracer.light().stage_irradiance(float(edge) - 0.008f, 0)[0], 0);
  EXPECT_GT(tracer.light().stage_irradiance(float(edge) + 0.008f, 0)[0], 0);
}

TEST(AreaLight, ShinesOnOneSideOnly) {
  const AreaLight light{.centre = {0, 0, 1}, .half_u = {1, 0, 0}, .half_v = {0, -1, 0}};
  EXPECT_TRUE(light.meet({0, 0, 0}, {0, 0, 1}));
  EXPECT_FALSE(light.meet({0, 0, 2}, {0, 0, -1}));
  EXPECT_FALSE(light.meet({1.5f, 0, 0}, {0, 0, 1}));
  EXPECT_FALSE(light.meet({0, 0, 0}, {0, 0, -1})) << "behind the ray";
  EXPECT_FLOAT_EQ(light.area(), 4);
}

}  // namespace
}  // namespace sheen
