// SPDX-License-Identifier: Apache-2.0
// Light adds up: pictures in lamps that the images never had, against exact pictures of the simulated object.
#include "reconstructor/render/luminaires.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "common/base/errors.h"
#include "common/image/color.h"
#include "common/image/image_metrics.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/support/lit_object.h"

namespace sheen {
namespace {

constexpr int kWidth = 80, kHeight = 60;
constexpr double kLamps = 0.45;  // height of the lamps' plane, metres

const LitObject& object() {
  static const LitObject object = LitObject::make(kWidth, kHeight);
  return object;
}
const std::vector<LightState>& far_lights() {
  static const std::vector<LightState> lights = dome_lights(13);
  return lights;
}
const IrradianceFieldSnapshot& far_field() {
  static const auto field = object().field(far_lights());
  return *field;
}
const IrradianceFieldSnapshot& near_field() {
  static const auto field = object().field(lamp_grid(9, 0.09, kLamps));
  return *field;
}

ImageF picture(const IrradianceFieldSnapshot& field, const std::vector<LightState>& lights) {
  const PosedCamera& from = field.cameras().front();
  return RayPainter(field.mesh())
      .paint(field, from.camera, from.camera_from_object, lights.front(), {lights.begin() + 1, lights.end()})
      .beauty;
}

double psnr_db(const ImageF& a, const ImageF& b) {
  return squared_error(to_srgb8(a), to_srgb8(b), {}).psnr_db();
}

/// Lamps of the truth that are as bright as the field's.
std::vector<LightState> as_bright(std::vector<LightState> lamps, float rgb = kLamps * kLamps) {
  for (LightState& lamp : lamps) lamp.rgb *= rgb;
  return lamps;
}

TEST(Luminaires, LightsOfSeveralColoursAddUpInLinearLight) {
  std::vector<LightState> lights{far_lights()[3], far_lights()[20]};
  lights[0].rgb = {0.8f, 0.2f, 0.1f};
  lights[1].rgb = {0.1f, 0.3f, 0.6f};
  // Between the field's own lights only rounding is lost.
  EXPECT_GT(psnr_db(picture(far_field(), lights), object().truth(lights)), 45);
  for (LightState& light : lights) light.position = (light.position + Eigen::Vector3d(0.05, -0.04, 0.1)).normalized();
  EXPECT_GT(psnr_db(picture(far_field(), lights), object().truth(lights)), 28);
}

const AreaLuminaire kPanel{{0.08, -0.06, kLamps}, {0, 0.12, 0}, {0.1, 0, 0}, {1, 0.9f, 0.8f}};

/// What a panel sends: each part as its cosine says, which no field of lamps knows.
ImageF panel_truth(const AreaLuminaire& panel) {
  constexpr int kSide = 16;
  std::vector<LightState> parts;
  for (const LightState& light : lights_of(panel, LightKind::kPoint, kSide)) parts.push_back(light);
  return object().truth(as_bright(std::move(parts)));
}

TEST(Luminaires, APanelOfTheLampsPlane) {
  const std::vector<LightState> parts = lights_of(kPanel, LightKind::kPoint, 8);
  EXPECT_EQ(parts.size(), 64u);
  EXPECT_GT(psnr_db(picture(near_field(), parts), panel_truth(kPanel)), 34);
}

/// At the origin what arrives is the integral of cosine over squared distance.
TEST(Luminaires, APanelIsAsBrightAtTheOriginAsItMustBe) {
  const AreaLuminaire tilted{{0.3, 0.1, 0.5}, {0, 0.2, 0}, Eigen::Vector3d(0.2, 0, -0.1), {1, 1, 1}};
  const Eigen::Vector3d normal = tilted.half_u.cross(tilted.half_v).normalized();
  const auto arrives = [&](const Eigen::Vector3d& place) { return -normal.dot(place) / std::pow(place.norm(), 3); };
  double truth = 0;
  constexpr int kSide = 200;
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j)
      truth += arrives(tilted.centre + ((2 * i + 1.0) / kSide - 1) * tilted.half_u +
                       ((2 * j + 1.0) / kSide - 1) * tilted.half_v) /
               (kSide * kSide);
  const double expected = truth / arrives(tilted.centre);  // of a lamp at its centre
  double near = 0, far = 0;
  for (const LightState& part : lights_of(tilted, LightKind::kPoint, 8))
    near += static_cast<double>(part.rgb[0]) * tilted.centre.squaredNorm() / part.position.squaredNorm();
  for (const LightState& part : lights_of(tilted, LightKind::kDirectional, 8)) far += static_cast<double>(part.rgb[0]);
  EXPECT_NEAR(near, expected, 2e-3);
  EXPECT_NEAR(far, expected, 2e-3);
}

constexpr int kSky = 32;  // rows of the map

/// A sky that is bright on one side, with a small coloured sun.
ImageF sky() {
  ImageF map(2 * kSky, kSky, 3);
  for (int y = 0; y < kSky; ++y)
    for (int x = 0; x < 2 * kSky; ++x)
      for (int c = 0; c < 3; ++c)
        map.at(x, y, c) = 0.2f + 0.004f * static_cast<float>(x) + 0.1f * static_cast<float>(c);
  for (int y = 10; y < 12; ++y)
    for (int x = 25; x < 27; ++x) map.at(x, y, 0) = 60, map.at(x, y, 1) = 40, map.at(x, y, 2) = 20;
  return map;
}

/// OpenEXR's map: longitude from pi on the left to -pi, latitude from pi / 2 at the top; z in its middle, y up.
Eigen::Vector3d direction_of(int x, int y) {
  const double longitude = std::numbers::pi * (1 - 2 * (x + 0.5) / (2 * kSky)),
               latitude = std::numbers::pi * (0.5 - (y + 0.5) / kSky);
  return {std::sin(longitude) * std::cos(latitude), std::sin(latitude), std::cos(longitude) * std::cos(latitude)};
}

TEST(Luminaires, AnEnvironment) {
  const ImageF map = sky();
  const EnvironmentLights found = lights_of(map, far_lights());
  EXPECT_GT(found.left_out, 0.4) << "what comes from below";
  EXPECT_LT(found.left_out, 0.8);
  // The truth of the same part of the sky, each pixel a light.
  double least = 1;
  for (const LightState& light : found.lights) least = std::min(least, light.position.z());
  std::vector<LightState> parts;
  for (int y = 0; y < kSky; ++y)
    for (int x = 0; x < 2 * kSky; ++x) {
      const Eigen::Vector3d direction = direction_of(x, y);
      if (direction.z() < least) continue;
      const double solid = std::cos(std::numbers::pi * (0.5 - (y + 0.5) / kSky)) * (std::numbers::pi / kSky) *
                           (std::numbers::pi / kSky) / std::numbers::pi;
      parts.push_back({LightKind::kDirectional, direction,
                       static_cast<float>(solid) * Eigen::Map<const Eigen::Vector3f>(map.pixel(x, y))});
    }
  EXPECT_GT(psnr_db(picture(far_field(), found.lights), object().truth(parts)), 32);
}

TEST(Luminaires, AnEnvironmentsLightIsAllThere) {
  ImageF map(64, 32, 3);
  std::fill_n(map.data(), map.size(), 1.0f);
  const std::vector<LightState> everywhere = [] {
    std::vector<LightState> lights = dome_lights(15);
    for (std::size_t i = 0, n = lights.size(); i < n; ++i) {
      lights.push_back(lights[i]);
      lights.back().position = -lights.back().position;
    }
    for (int i = 0; i < 24; ++i)
      for (const double z : {-0.25, 0.0, 0.25})
        lights.push_back(
            {.kind = LightKind::kDirectional, .position = {std::cos(i * 0.2618), std::sin(i * 0.2618), z}});
    return lights;
  }();
  const EnvironmentLights found = lights_of(map, everywhere);
  EXPECT_NEAR(found.left_out, 0, 1e-9);
  double up = 0, all = 0;
  for (const LightState& light : found.lights) {
    all += static_cast<double>(light.rgb[1]);
    up += static_cast<double>(light.rgb[1]) * std::max(0.0, light.position.z());
  }
  EXPECT_NEAR(all, 4, 0.01) << "4 pi over pi";
  EXPECT_NEAR(up, 1, 0.01) << "a white surface in a white room is white";
  std::fill_n(map.data(), map.size(), 0.0f);
  EXPECT_THROW(lights_of(map, everywhere), ConfigError);
}

/// Off the plane a lamp is taken for the one that the origin sees behind it: right at the origin's height.
TEST(Luminaires, NearLampsStandForOthersOffTheirPlane) {
  for (const double height : {0.9, 1.15}) {
    const LightState lamp{.kind = LightKind::kPoint, .position = height * Eigen::Vector3d(0.07, 0.05, kLamps)};
    const ImageF truth = object().truth(as_bright({lamp}));
    EXPECT_GT(psnr_db(picture(near_field(), {lamp}), truth), 22) << height;
    // A lamp of the plane in its place is worse.
    const LightState below{.kind = LightKind::kPoint, .position = {lamp.position.x(), lamp.position.y(), kLamps}};
    EXPECT_GT(psnr_db(picture(near_field(), {lamp}), truth), psnr_db(picture(near_field(), {below}), truth) + 0.5);
  }
}

TEST(Luminaires, NearLampsStandForFarLights) {
  const LightState far{.kind = LightKind::kDirectional, .position = Eigen::Vector3d(0.2, 0.1, 1).normalized()};
  const ImageF seen = picture(near_field(), {far}), truth = object().truth(std::vector{far});
  EXPECT_GT(psnr_db(seen, truth), 18);
  const LightState grazing{.kind = LightKind::kDirectional, .position = {1, 0, 0.01}};
  EXPECT_THROW(picture(near_field(), {grazing}), ConfigError);
  EXPECT_THROW(picture(far_field(), {{.kind = LightKind::kPoint, .position = {0, 0, 1}}}), ConfigError);
}

TEST(Luminaires, APathGoesThroughItsLights) {
  std::vector<LightState> keys;
  for (const double x : {0.0, 1.0, 2.0, 3.0})
    keys.push_back({.kind = LightKind::kPoint, .position = {x, 2 * x, 5}, .rgb = {1, static_cast<float>(x), 0}});
  const std::vector<LightState> path = light_path(keys, 7);
  ASSERT_EQ(path.size(), 7u);
  for (int i = 0; i < 7; ++i) {
    // Where the keys go on evenly, as beyond the first and the last they do not, the path is straight.
    if (i > 1 && i < 5) EXPECT_NEAR((path[i].position - Eigen::Vector3d(0.5 * i, i, 5)).norm(), 0, 1e-12) << i;
    EXPECT_NEAR(path[i].rgb[1], 0.5 * i, 1e-6);
  }
  EXPECT_EQ(path.front().position, keys.front().position);
  EXPECT_EQ(path.back().position, keys.back().position);
}

}  // namespace
}  // namespace sheen
