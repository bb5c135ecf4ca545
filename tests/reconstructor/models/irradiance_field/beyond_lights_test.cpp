// SPDX-License-Identifier: Apache-2.0
// An irradiance field in lights that come from where none of its images' lights did, and from eyes where no camera was.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/image/color.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/reconstructor/models/irradiance_field/lambertian_relief.h"

namespace sheen {
namespace {

Eigen::Vector3d direction(double elevation_deg, double azimuth_deg) {
  const double up = elevation_deg * kDegree, round = azimuth_deg * kDegree;
  return {std::cos(up) * std::cos(round), std::cos(up) * std::sin(round), std::sin(up)};
}

/// Lights of one elevation; without a count, a dome of them.
struct Lights {
  std::string name;
  int count = 0;
  double elevation_deg = 0, arc_deg = 360;

  std::vector<Eigen::Vector3d> all() const {
    if (count == 0) return dome_of_lights();
    std::vector<Eigen::Vector3d> lights;
    for (int i = 0; i < count; ++i) lights.push_back(direction(elevation_deg, arc_deg * i / count));
    return lights;
  }
};

class BeyondLights : public ::testing::TestWithParam<Lights> {
 protected:
  using Levels = std::vector<float>;  ///< grey levels, sRGB-encoded
  static Levels levels(const ImageF& picture) {
    Levels values(picture.data(), picture.data() + picture.size());
    for (float& value : values) value = 255 * srgb_encode(value);
    return values;
  }
  Levels seen_in(const Eigen::Vector3d& light) const {
    return levels(dynamic_cast<const IrradianceFieldSnapshot&>(*snapshot_)
                      .picture({.kind = LightKind::kDirectional, .position = light}));
  }

  LambertianRelief relief_;
  std::shared_ptr<const ModelSnapshot> snapshot_ = relief_.model(GetParam().all())->snapshot();
};

TEST_P(BeyondLights, PicturesStayWithinWhatWasSeenAndChangeSmoothly) {
  Levels low, high;
  for (const Eigen::Vector3d& light : GetParam().all()) {
    const Levels seen = levels(relief_.picture(light));
    if (low.empty()) low = high = seen;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      low[i] = std::min(low[i], seen[i]);
      high[i] = std::max(high[i], seen[i]);
    }
  }
  float excess = 0, flicker = 0;
  for (double elevation = -89; elevation <= 89; elevation += 17.8)
    for (double azimuth = 5; azimuth < 360; azimuth += 30) {
      const Levels here = seen_in(direction(elevation, azimuth)), beside = seen_in(direction(elevation + 1, azimuth));
      float e = 0;
      for (std::size_t i = 0; i < here.size(); ++i) {
        e = std::max({e, here[i] - high[i], low[i] - here[i]});
        flicker = std::max(flicker, std::abs(beside[i] - here[i]));
      }
      excess = std::max(e, excess);
    }
  EXPECT_LT(excess, 32);
  EXPECT_LT(flicker, 6);
}

TEST_P(BeyondLights, FromAllSidesItIsTheSamePictureAndGreyFromBehind) {
  const RayPainter painter(snapshot_->mesh());
  const LightState light{.kind = LightKind::kDirectional, .position = GetParam().all().front()};
  for (const double elevation : {-80.0, -30.0, 30.0, 80.0}) {
    const Eigen::Vector3d eye = direction(elevation, 40);
    const auto shader = snapshot_->shader_for({eye, light}), first = snapshot_->shader_for({{0, 0, 1}, light});
    for (const float u : {0.1f, 0.4f, 0.8f}) EXPECT_EQ(shader->shade(0, u, 0.1f).rgb, first->shade(0, u, 0.1f).rgb);
    const Rigid3 pose = look_at(eye, {0, 0, 0}, {0, 1, 0});
    const PaintedView view = painter.paint(*snapshot_, relief_.camera().camera, pose, light);
    const int x = relief_.width / 2, y = relief_.height / 2;
    EXPECT_EQ(view.coverage.at(x, y), elevation > 0 ? kCoverageMeasured : kCoverageUnseen) << elevation;
  }
}

INSTANTIATE_TEST_SUITE_P(Lights, BeyondLights,
                         ::testing::Values(Lights{"Dome"}, Lights{"OneRing", 12, 40}, Lights{"ThreeLights", 3, 50},
                                           Lights{"ShortArc", 7, 45, 60}, Lights{"Low", 16, 20},
                                           Lights{"OneLight", 1, 60}),
                         [](const auto& lights) { return lights.param.name; });

}  // namespace
}  // namespace sheen
