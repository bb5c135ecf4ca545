// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/light_intervals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/image/color.h"
#include "tests/reconstructor/models/irradiance_field/lambertian_relief.h"
#include "tests/support/lit_object.h"

namespace sheen {
namespace {

using Pair = std::array<Eigen::Index, 2>;

TEST(LightIntervals, NeighboursHaveNobodyBetweenThem) {
  Eigen::Matrix3Xd square(3, 5);
  square.col(0) << 0, 0, 0;
  square.col(1) << 2, 0, 0;
  square.col(2) << 0, 2, 0;
  square.col(3) << 2, 2, 0;
  square.col(4) << 1.1, 0.9, 0;
  EXPECT_THAT(neighbours(square),
              testing::UnorderedElementsAre(Pair{0, 4}, Pair{1, 4}, Pair{2, 4}, Pair{3, 4}, Pair{0, 2}, Pair{2, 3}));
}

/// 99 % of the pixels are off by less, in grey levels, each by its worst colour.
double true_error(const ImageF& picture, const ImageF& truth) {
  std::vector<float> errors;
  for (std::size_t i = 0; i < truth.size(); i += 3) {
    float largest = 0;
    for (std::size_t c = i; c < i + 3; ++c)
      largest =
          std::max(largest, std::abs(srgb_encode(std::max(0.0f, picture.data()[c])) - srgb_encode(truth.data()[c])));
    errors.push_back(255 * largest);
  }
  std::sort(errors.begin(), errors.end());
  return static_cast<double>(errors[static_cast<std::size_t>(0.99 * static_cast<double>(errors.size() - 1))]);
}

/// A glossy object's errors half way between two lights, where there is truth: of the right size, and the worst
/// intervals are among those that are said to be.
TEST(LightIntervals, PredictsWhatIsMissedHalfWay) {
  const LitObject object = LitObject::make(64, 48, 0.5f, 30);
  std::vector<LightState> lights = dome_lights(15);
  const auto field = object.field(lights);
  const LightAdvice advice = *field->advise_next_light(4);
  double log_ratio = 0, counted = 0, best_half = 0, worst_half = 0;
  for (std::size_t i = 0; i < advice.intervals.size(); i += 4) {
    const LightInterval& interval = advice.intervals[i];
    LightState middle = interval.from;
    middle.position = (interval.from.position + interval.to.position).normalized();
    const double error = true_error(field->picture(middle), object.scene.picture(middle));
    log_ratio += std::log2(interval.error / error);
    counted += 1;
    (i < advice.intervals.size() / 2 ? worst_half : best_half) += error;
  }
  EXPECT_NEAR(log_ratio / counted, 0, 1) << "right to a factor of 2 on average";
  EXPECT_GT(worst_half, 1.1 * best_half);
}

TEST(LightIntervals, TheNextLightGoesWhereOneIsMissing) {
  const LambertianRelief relief{.tilt = 0.5};
  std::vector<Eigen::Vector3d> lights = dome_of_lights();
  const Eigen::Vector3d hole = Eigen::Vector3d(0.6, 0.1, 0.7).normalized();
  std::erase_if(lights, [&](const Eigen::Vector3d& light) { return light.normalized().dot(hole) > std::cos(0.5); });
  const auto field = std::dynamic_pointer_cast<const IrradianceFieldSnapshot>(relief.model(lights)->snapshot());
  const LightAdvice advice = *field->advise_next_light(16);
  double nearest = 0;
  for (const Eigen::Vector3d& light : lights) nearest = std::max(nearest, light.normalized().dot(hole));
  EXPECT_GT(advice.next.position.dot(hole), nearest) << "nearer to the middle of the hole than any light";
  for (const LightInterval& interval : advice.intervals) {
    EXPECT_EQ(interval.too_wide(), interval.error > 16);
    EXPECT_EQ(interval.too_wide(), interval.required < interval.length);
  }
}

TEST(LightIntervals, CloserLightsMissLess) {
  const LitObject object = LitObject::make(48, 36, 0.5f, 20);
  // Domes that reach down to 30 degrees alike: lower lights are harder to predict.
  const auto mean_error = [&](double step_deg) {
    const LightAdvice advice = *object.field(dome_lights(step_deg))->advise_next_light(16);
    double sum = 0;
    for (const LightInterval& interval : advice.intervals) sum += interval.error;
    return sum / static_cast<double>(advice.intervals.size());
  };
  EXPECT_LT(mean_error(10), 0.8 * mean_error(20));
}

TEST(LightIntervals, FewLightsSayNothing) {
  const LambertianRelief relief;
  const auto model = relief.model({{0, 0, 1}, {0.5, 0, 1}, {-0.4, 0.3, 1}, {0.1, -0.6, 1}});
  EXPECT_FALSE(model->snapshot()->advise_next_light(16));
}

}  // namespace
}  // namespace sheen
