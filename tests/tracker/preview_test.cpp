// SPDX-License-Identifier: Apache-2.0
#include "tracker/preview.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/tracker/synthetic_stage.h"

namespace sheen {
namespace {

RawImage raw(const ImageU8& picture) {
  return {.format = PixelFormat::kMono8,
          .transfer = Transfer::kLinear,
          .width = picture.width(),
          .height = picture.height(),
          .stride = std::size_t(picture.width()),
          .bytes = {picture.data(), picture.data() + picture.size()}};
}

ImageU8 stage_picture() {
  std::mt19937 rng(11);
  return testing::render_stage(testing::stage_camera(), make_stage({}), testing::random_stage_pose(rng, 40), 4);
}

/// Means of (2 reach + 1)^2 pixels.
ImageU8 defocused(const ImageU8& sharp, int reach) {
  ImageU8 soft = sharp;
  for (int y = 0; y < sharp.height(); ++y)
    for (int x = 0; x < sharp.width(); ++x) {
      int sum = 0, count = 0;
      for (int v = std::max(0, y - reach); v <= std::min(sharp.height() - 1, y + reach); ++v)
        for (int u = std::max(0, x - reach); u <= std::min(sharp.width() - 1, x + reach); ++u, ++count)
          sum += sharp.at(u, v);
      soft.at(x, y) = static_cast<std::uint8_t>(sum / count);
    }
  return soft;
}

TEST(Preview, FocusFallsWithDefocusAndNotWithExposure) {
  TagDetector detector;
  const ImageU8 sharp = stage_picture();
  const ImageLook best = inspect(raw(sharp), detector);
  EXPECT_GT(best.tags, 10u);
  double before = best.focus;
  for (const int reach : {1, 2, 4}) {
    const double focus = inspect(raw(defocused(sharp, reach)), detector).focus;
    EXPECT_LT(focus, 0.8 * before) << reach;
    before = focus;
  }
  ImageU8 darker = sharp;
  for (std::size_t i = 0; i < darker.size(); ++i) darker.data()[i] /= 2;
  EXPECT_NEAR(inspect(raw(darker), detector).focus / best.focus, 1, 0.05);
}

TEST(Preview, CountsClippedAndDarkPixelsExactly) {
  TagDetector detector;
  ImageU8 picture(40, 20, 1, 100);
  for (int x = 0; x < 40; ++x) picture.at(x, 3) = 255;
  for (int x = 0; x < 20; ++x) picture.at(x, 4) = 0;
  const ImageLook look = inspect(raw(picture), detector);
  EXPECT_DOUBLE_EQ(look.clipped, 40.0 / 800);
  EXPECT_DOUBLE_EQ(look.dark, 20.0 / 800);
  EXPECT_NEAR(look.mean, (740 * 100.0 + 40 * 255) / 800 / 255, 1e-12);
  EXPECT_EQ(advice(look), "too bright: shorten the exposure");
  EXPECT_EQ(advice(inspect(raw(ImageU8(40, 20, 1, 5)), detector)), "too dark: lengthen the exposure, or add light");
  EXPECT_NE(advice(inspect(raw(ImageU8(40, 20, 1, 100)), detector)).find("no tag"), std::string::npos);
}

}  // namespace
}  // namespace sheen
