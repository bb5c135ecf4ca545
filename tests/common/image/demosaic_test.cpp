// SPDX-License-Identifier: Apache-2.0
#include "common/image/demosaic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "common/image/image.h"
#include "common/simulation/sensor.h"

namespace sheen {
namespace {

using Picture = std::function<double(int x, int y, int c)>;  // encoded, of any integer place

/// Colour that the site (x, y) of an RGGB mosaic measures.
int own_colour(int x, int y) {
  return (x & 1) + (y & 1);
}

ImageF demosaiced(int width, int height, const Picture& picture) {
  ImageF rgb(width, height, 3, -1);
  demosaic(
      width, height,
      [&](int y, std::span<float> sites) {
        for (int i = 0; i < int(sites.size()); ++i) {
          const int x = i - kDemosaicReach;
          sites[i] = static_cast<float>(picture(x, y, own_colour(x, y)));
        }
      },
      [&](int y, const float* red, const float* green, const float* blue) {
        for (int x = 0; x < width; ++x) {
          rgb.at(x, y, 0) = red[x];
          rgb.at(x, y, 1) = green[x];
          rgb.at(x, y, 2) = blue[x];
        }
      });
  return rgb;
}

/// What only averages sites of the colour itself.
double linearly_interpolated(const Picture& picture, int x, int y, int c) {
  double sum = 0, weights = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const bool here = dx == 0 && dy == 0;
      if (own_colour(x + dx, y + dy) != c || (own_colour(x, y) == c && !here)) continue;
      sum += picture(x + dx, y + dy, c);
      weights += 1;
    }
  return sum / weights;
}

/// Malvar, He and Cutler (2004): every missing colour corrected by the curvature of the one that is there, by a fixed
/// gain.
double by_fixed_gains(const Picture& picture, int x, int y, int c) {
  const int own = own_colour(x, y);
  if (own == c) return picture(x, y, c);
  const auto at = [&](int dx, int dy) { return picture(x + dx, y + dy, own_colour(x + dx, y + dy)); };
  const double beside = at(-1, 0) + at(1, 0), above = at(0, -1) + at(0, 1);
  const double beside2 = at(-2, 0) + at(2, 0), above2 = at(0, -2) + at(0, 2);
  const double diagonal = at(-1, -1) + at(1, -1) + at(-1, 1) + at(1, 1);
  if (c == 1) return (4 * at(0, 0) + 2 * (beside + above) - beside2 - above2) / 8;
  if (own != 1) return (6 * at(0, 0) + 2 * diagonal - 1.5 * (beside2 + above2)) / 8;
  const bool in_row = own_colour(x + 1, y) == c;
  return (5 * at(0, 0) + 4 * (in_row ? beside : above) - diagonal - (in_row ? beside2 : above2) +
          0.5 * (in_row ? above2 : beside2)) /
         8;
}

double mean_squared_error(int width, int height, const Picture& truth, const Picture& picture) {
  double sum = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) sum += std::pow(picture(x, y, c) - truth(x, y, c), 2);
  return sum / (3.0 * width * height);
}

TEST(Demosaic, AffinePlanesAreReturnedExactly) {
  const Picture picture = [](int x, int y, int c) {
    const double slopes[3][2] = {{0.004, -0.002}, {0.001, 0.003}, {-0.005, 0.001}};
    return 0.5 + 0.1 * c + slopes[c][0] * x + slopes[c][1] * y;
  };
  const ImageF rgb = demosaiced(40, 30, picture);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgb.at(x, y, c), picture(x, y, c), 1e-6) << x << ' ' << y << ' ' << c;
}

// Stripes of one pixel and a bit, whose colours vary together by different amounts: what a colour's own sites miss,
// green tells.
TEST(Demosaic, DetailThatColoursShareIsKept) {
  for (const bool upright : {true, false}) {
    const Picture picture = [&](int x, int y, int c) {
      const double gains[3] = {0.7, 1.0, 0.5}, offsets[3] = {0.25, 0.1, 0.3};
      return offsets[c] + gains[c] * 0.2 * (1 + std::sin(1.9 * (upright ? x : y)));
    };
    const ImageF rgb = demosaiced(64, 48, picture);
    const double error = mean_squared_error(64, 48, picture, [&](int x, int y, int c) { return rgb.at(x, y, c); });
    const double linear = mean_squared_error(
        64, 48, picture, [&](int x, int y, int c) { return linearly_interpolated(picture, x, y, c); });
    EXPECT_LT(error, 0.02 * linear) << (upright ? "upright" : "lying");
  }
}

// Red texture on even green: there is nothing to learn from green, and nothing of red may reach it.
TEST(Demosaic, AColourThatVariesAloneLeavesTheOthersAlone) {
  const Picture picture = [](int x, int y, int c) {
    return c == 0 ? 0.4 + 0.15 * std::sin(0.9 * x) * std::sin(0.7 * y) : 0.4;
  };
  const ImageF rgb = demosaiced(64, 48, picture);
  double worst = 0, worst_by_fixed_gains = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 1; c < 3; ++c) {
        worst = std::max(worst, std::abs(rgb.at(x, y, c) - picture(x, y, c)));
        worst_by_fixed_gains =
            std::max(worst_by_fixed_gains, std::abs(by_fixed_gains(picture, x, y, c) - picture(x, y, c)));
      }
  EXPECT_GT(worst_by_fixed_gains, 0.05);
  EXPECT_LT(worst, 0.1 * worst_by_fixed_gains);
}

/// Patches of random colours, some of them textured in grey, as a lens shows them.
ImageF patches(int size) {
  ImageF sharp(size, size, 3);
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> uniform(0.1f, 0.9f);
  for (int y0 = 0; y0 < size; y0 += 12)
    for (int x0 = 0; x0 < size; x0 += 12) {
      const float colour[3] = {uniform(engine), uniform(engine), uniform(engine)};
      const bool textured = engine() % 2;
      for (int y = y0; y < std::min(y0 + 12, size); ++y)
        for (int x = x0; x < std::min(x0 + 12, size); ++x) {
          const float shade = textured ? 0.6f + 0.4f * uniform(engine) : 1;
          for (int c = 0; c < 3; ++c) sharp.at(x, y, c) = shade * colour[c];
        }
    }
  return through_lens(sharp, kLensSpotPx);
}

TEST(Demosaic, LosesLessThanInterpolationAndThanFixedGains) {
  constexpr int kSize = 120, kInside = 96;
  const ImageF linear = patches(kSize);
  const Picture picture = [&](int x, int y, int c) {
    return root_encode(linear.at(x + kDemosaicReach, y + kDemosaicReach, c));
  };
  const ImageF rgb = demosaiced(kInside, kInside, picture);
  const auto error_db = [&](const Picture& p) {
    return -10 * std::log10(mean_squared_error(kInside, kInside, picture, p));
  };
  const double ours = error_db([&](int x, int y, int c) { return rgb.at(x, y, c); });
  EXPECT_GT(ours, 1 + error_db([&](int x, int y, int c) { return linearly_interpolated(picture, x, y, c); }));
  EXPECT_GT(ours, 1 + error_db([&](int x, int y, int c) { return by_fixed_gains(picture, x, y, c); }));
}

TEST(Demosaic, TheRootEncodingIsUndone) {
  for (const float linear : {0.0f, 1e-6f, 0.001f, 0.02f, 0.5f, 1.0f})
    EXPECT_NEAR(root_decode(root_encode(linear)), linear, 3e-7 * (1 + linear));
  EXPECT_NEAR(root_decode(-0.02f), 0, 1e-9) << "below black is black";
}

TEST(Demosaic, TheWorstMosaicsGiveFiniteValues) {
  std::mt19937 engine(9);
  const Picture harsh = [&](int, int, int) { return engine() % 2 ? 1.0 : 0.0; };
  const ImageF rgb = demosaiced(80, 60, harsh);
  EXPECT_TRUE(std::all_of(rgb.data(), rgb.data() + rgb.size(), [](float v) { return std::abs(v) < 4; }));
}

}  // namespace
}  // namespace sheen
