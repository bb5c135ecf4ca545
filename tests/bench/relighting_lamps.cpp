// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/relighting_lamps.h"

#include <cmath>

#include "common/image/color.h"
#include "common/image/image_metrics.h"
#include "reconstructor/render/luminaires.h"
#include "tests/support/lit_object.h"

namespace sheen {
namespace {

constexpr int kWidth = 160, kHeight = 120, kPerSide = 13;
constexpr double kHeightOfLamps = 0.45, kSpacing = 0.06;

ImageF sum_of_pictures(const IrradianceFieldSnapshot& field, const std::vector<LightState>& lights) {
  ImageF sum(kWidth, kHeight, 3);
  for (const LightState& light : lights) {
    const ImageF more = field.picture(light);
    for (std::size_t i = 0; i < sum.size(); ++i) sum.data()[i] += more.data()[i];
  }
  return sum;
}

double psnr_db(const ImageF& a, const ImageF& b) {
  return squared_error(to_srgb8(a), to_srgb8(b), {}).psnr_db();
}

std::vector<LightState> as_bright(std::vector<LightState> lamps) {
  for (LightState& lamp : lamps) lamp.rgb *= static_cast<float>(kHeightOfLamps * kHeightOfLamps);
  return lamps;
}

/// A sky with a small sun; each of its pixels is a light of the truth, from 25 degrees above the horizon up.
ImageF sky(int rows) {
  ImageF map(2 * rows, rows, 3);
  const double polar = std::numbers::pi / rows;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < 2 * rows; ++x) {
      const double longitude = std::numbers::pi - polar * (x + 0.5), s = std::sin(polar * (y + 0.5));
      const Eigen::Vector3d direction(std::sin(longitude) * s, std::cos(polar * (y + 0.5)), std::cos(longitude) * s);
      if (direction.z() < std::sin(0.44)) continue;
      const double sun = 30 * std::exp(-60 * (direction - Eigen::Vector3d(0.4, 0.3, 0.87).normalized()).squaredNorm());
      Eigen::Map<Eigen::Vector3f>(map.pixel(x, y)) =
          Eigen::Vector3d(0.2 + sun, 0.3 + 0.8 * sun, 0.5 + 0.5 * sun).cast<float>();
    }
  return map;
}

std::vector<LightState> each_pixel(const ImageF& map) {
  std::vector<LightState> lights;
  const double polar = std::numbers::pi / map.height();
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) {
      const double longitude = std::numbers::pi - polar * (x + 0.5), s = std::sin(polar * (y + 0.5));
      const Eigen::Vector3f radiance = Eigen::Map<const Eigen::Vector3f>(map.pixel(x, y));
      if (radiance.isZero()) continue;
      lights.push_back({LightKind::kDirectional,
                        {std::sin(longitude) * s, std::cos(polar * (y + 0.5)), std::cos(longitude) * s},
                        static_cast<float>(s * polar * polar / std::numbers::pi) * radiance});
    }
  return lights;
}

}  // namespace

void report_lamps(GoalReport& report) {
  const LitObject object = LitObject::make(kWidth, kHeight);
  const std::vector<LightState> dome = dome_lights(10);
  const auto far = object.field(dome);
  const ImageF map = sky(40);
  report.add({"an environment with a small sun, field of " + std::to_string(dome.size()) + " far lights",
              psnr_db(sum_of_pictures(*far, lights_of(map, dome).lights), object.truth(each_pixel(map))),
              "dB",
              {}});
  const auto near = object.field(lamp_grid(kPerSide, kSpacing, kHeightOfLamps));
  const AreaLuminaire panel{{0.08, -0.06, kHeightOfLamps}, {0, 0.12, 0}, {0.1, 0, 0}, {1, 0.9f, 0.8f}};
  report.add({"a panel of 24 x 20 cm in the plane of 13 x 13 lamps",
              psnr_db(sum_of_pictures(*near, lights_of(panel, LightKind::kPoint, 8)),
                      object.truth(as_bright(lights_of(panel, LightKind::kPoint, 20)))),
              "dB",
              {}});
  for (const double height : {1.0, 0.95, 1.05, 0.9, 1.1, 0.75, 1.25}) {
    const LightState lamp{.kind = LightKind::kPoint,
                          .position = height * Eigen::Vector3d(0.073, 0.052, kHeightOfLamps)};
    const LightState below{.kind = LightKind::kPoint,
                           .position = {lamp.position.x(), lamp.position.y(), kHeightOfLamps}};
    const ImageF truth = object.truth(as_bright({lamp}));
    char name[80];
    std::snprintf(name, sizeof name, "a lamp at %.0f %% of the plane's distance", 100 * height);
    report.add({name,
                psnr_db(near->picture(lamp), truth),
                "dB",
                {},
                true,
                {{"the plane's lamp right below or above it", psnr_db(near->picture(below), truth)}}});
  }
}

}  // namespace sheen
