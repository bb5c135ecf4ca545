// SPDX-License-Identifier: Apache-2.0
#include "common/image/image_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "support/expect_error.h"

namespace sheen {
namespace {

ImageU8 random_image(int width, int height, int channels, unsigned seed) {
  std::mt19937 random(seed);
  ImageU8 image(width, height, channels);
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<std::uint8_t>(random());
  return image;
}

/// The definition, pixel by pixel in double, window clipped to the image and made to sum to 1.
double slow_ssim(const ImageU8& a, const ImageU8& b, const ImageU8& mask) {
  const double c1 = std::pow(0.01 * 255, 2), c2 = std::pow(0.03 * 255, 2);
  double total = 0;
  int count = 0;
  for (int c = 0; c < a.channels(); ++c)
    for (int y = 0; y < a.height(); ++y)
      for (int x = 0; x < a.width(); ++x) {
        if (!mask.empty() && !mask.at(x, y)) continue;
        double weight = 0, ma = 0, mb = 0;
        const auto each = [&](auto visit) {
          for (int dy = -5; dy <= 5; ++dy)
            for (int dx = -5; dx <= 5; ++dx)
              if (x + dx >= 0 && x + dx < a.width() && y + dy >= 0 && y + dy < a.height())
                visit(std::exp(-(dx * dx + dy * dy) / 4.5), a.at(x + dx, y + dy, c), b.at(x + dx, y + dy, c));
        };
        each([&](double w, double va, double vb) { weight += w, ma += w * va, mb += w * vb; });
        ma /= weight, mb /= weight;
        double vara = 0, varb = 0, cov = 0;
        each([&](double w, double va, double vb) {
          vara += w / weight * (va - ma) * (va - ma);
          varb += w / weight * (vb - mb) * (vb - mb);
          cov += w / weight * (va - ma) * (vb - mb);
        });
        total += (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (vara + varb + c2));
        ++count;
      }
  return total / count;
}

TEST(Psnr, ClosedForms) {
  ImageU8 a(10, 5, 3, 100), b(10, 5, 3, 110);
  EXPECT_EQ(squared_error(a, a, {}).psnr_db(), std::numeric_limits<double>::infinity());
  const SquaredError error = squared_error(a, b, {});
  EXPECT_EQ(error.sum, 100 * 150);
  EXPECT_EQ(error.count, 150u);
  EXPECT_NEAR(error.psnr_db(), 20 * std::log10(255.0 / 10), 1e-12);
  EXPECT_NEAR(squared_error(ImageU8(2, 2, 1, 0), ImageU8(2, 2, 1, 255), {}).psnr_db(), 0, 1e-12);
}

TEST(Psnr, OnlyUnderTheMaskAndPooled) {
  ImageU8 a(4, 1, 1, 10), b(4, 1, 1, 10), mask(4, 1, 1, 0);
  b.at(0, 0) = 255;
  b.at(1, 0) = 16;
  mask.at(1, 0) = 1;
  mask.at(2, 0) = 255;
  SquaredError pool = squared_error(a, b, mask);
  EXPECT_EQ(pool.sum, 36);
  EXPECT_EQ(pool.count, 2u);
  pool += squared_error(a, a, mask);
  EXPECT_NEAR(pool.psnr_db(), 10 * std::log10(255.0 * 255 * 4 / 36), 1e-12);
  EXPECT_TRUE(std::isnan(squared_error(a, b, ImageU8(4, 1, 1, 0)).psnr_db()));
}

TEST(Ssim, AgreesWithTheDefinition) {
  for (const auto& [width, height, channels] : {std::tuple(40, 31, 3), {5, 60, 1}, {1, 1, 3}, {11, 4, 2}}) {
    const ImageU8 a = random_image(width, height, channels, 1);
    ImageU8 b = random_image(width, height, channels, 2);
    for (std::size_t i = 0; i < b.size(); ++i) b.data()[i] = std::uint8_t((3 * a.data()[i] + b.data()[i]) / 4);
    EXPECT_NEAR(ssim(a, b, {}), slow_ssim(a, b, {}), 1e-5) << width << " x " << height;
    ImageU8 mask = random_image(width, height, 1, 3);
    for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = mask.data()[i] < 40 ? 0 : mask.data()[i];
    for (int x = 0; x < width; ++x)
      for (int y = height / 3; y < height / 2; ++y) mask.at(x, y) = 0;  // rows without any pixel
    if (width > 1) {
      EXPECT_NEAR(ssim(a, b, mask), slow_ssim(a, b, mask), 1e-5);
    }
  }
}

TEST(Ssim, AgreesWithTheDefinitionOnBrightFlatImages) {
  // Small variance on a large mean is where sums of squares cancel.
  ImageU8 a(30, 30, 1), b(30, 30, 1);
  std::mt19937 random(4);
  for (std::size_t i = 0; i < a.size(); ++i) {
    a.data()[i] = std::uint8_t(250 + random() % 3);
    b.data()[i] = std::uint8_t(250 + random() % 3);
  }
  EXPECT_NEAR(ssim(a, b, {}), slow_ssim(a, b, {}), 2e-4);
}

TEST(Ssim, ClosedForms) {
  const ImageU8 a = random_image(20, 20, 3, 1);
  EXPECT_NEAR(ssim(a, a, {}), 1, 1e-6);
  // Of two flat images only the luminance term is left.
  const double c1 = std::pow(0.01 * 255, 2);
  EXPECT_NEAR(ssim(ImageU8(20, 20, 1, 50), ImageU8(20, 20, 1, 200), {}),
              (2 * 50 * 200 + c1) / (50 * 50 + 200 * 200 + c1), 5e-5)
      << "moments are float";
  EXPECT_TRUE(std::isnan(ssim(a, a, ImageU8(20, 20, 1, 0))));
}

TEST(Erode, ByASquareAndNotFromTheBorder) {
  ImageU8 mask(9, 7, 1, 255);
  mask.at(4, 3) = 0;
  const ImageU8 once = erode(mask, 1), twice = erode(mask, 2);
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 9; ++x) {
      const int distance = std::max(std::abs(x - 4), std::abs(y - 3));
      EXPECT_EQ(once.at(x, y) != 0, distance > 1) << x << ", " << y;
      EXPECT_EQ(twice.at(x, y) != 0, distance > 2) << x << ", " << y;
    }
  EXPECT_EQ(erode(mask, 0), mask);
  EXPECT_EQ(erode(once, 1), twice);
  EXPECT_EQ(erode(ImageU8(3, 3, 1, 7), 50), ImageU8(3, 3, 1, 7));
  EXPECT_TRUE(erode({}, 3).empty());
}

TEST(Metrics, SizesThatDoNotMatchAreErrors) {
  const ImageU8 a(4, 4, 3), b(5, 4, 3), grey(4, 4, 1);
  expect_error<Error>([&] { squared_error(a, b, {}); }, {"4 x 4", "5 x 4"});
  expect_error<Error>([&] { ssim(a, grey, {}); }, {"channels"});
  expect_error<Error>([&] { ssim(a, a, ImageU8(4, 5, 1)); }, {"mask", "4 x 5"});
}

}  // namespace
}  // namespace sheen
