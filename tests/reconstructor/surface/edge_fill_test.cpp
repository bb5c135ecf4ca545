// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/edge_fill.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

const float kColour[] = {0.3f, 0.5f, 0.7f};

int distance_from_disc(int x, int y) {  // in pixels, along an axis or a diagonal, from the disc's nearest pixel
  int nearest = 1000;
  for (int j = 0; j < 40; ++j)
    for (int i = 0; i < 50; ++i)
      if (std::hypot(i - 24, j - 19) < 11) nearest = std::min(nearest, std::max(std::abs(i - x), std::abs(j - y)));
  return nearest;
}

TEST(EdgeFill, AColourIsContinuedByTwoPixelsAndNotFurther) {
  ImageF safe(50, 40, 1), pixels(50, 40, 3);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 50; ++x)
      if (distance_from_disc(x, y) == 0) {
        safe.at(x, y) = 2;
        std::copy_n(kColour, 3, pixels.pixel(x, y));
      }
  fill_edges(safe, 0, 0, pixels);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 50; ++x)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(pixels.at(x, y, c), distance_from_disc(x, y) <= kFilledPixels ? kColour[c] : 0, 1e-6f)
            << x << ' ' << y;
}

TEST(EdgeFill, TakesTheMeanOfWhatItTouchesAndLeavesSafePixelsAlone) {
  // Safe: (2, 2) and (4, 2). Between them and round them others.
  ImageF safe(7, 5, 1), pixels(7, 5, 1, 100.0f);
  safe.at(2, 2) = safe.at(4, 2) = 1;
  pixels.at(2, 2) = 3;
  pixels.at(4, 2) = 5;
  fill_edges(safe, 0, 0, pixels);
  EXPECT_EQ(pixels.at(2, 2), 3);
  EXPECT_EQ(pixels.at(4, 2), 5);
  for (int y = 1; y <= 3; ++y) {
    EXPECT_EQ(pixels.at(1, y), 3);
    EXPECT_EQ(pixels.at(3, y), 4) << "touches both";
    EXPECT_EQ(pixels.at(5, y), 5);
  }
  EXPECT_EQ(pixels.at(0, 0), 3);
  EXPECT_FLOAT_EQ(pixels.at(2, 0), 10.0f / 3) << "touches two pixels that became 3 and one that became 4";
  EXPECT_EQ(pixels.at(6, 4), 5);
}

TEST(EdgeFill, APartOfTheImageIsFilledAsTheWholeIs) {
  ImageF safe(40, 30, 1), whole(40, 30, 4);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) {
      safe.at(x, y) = std::hypot(x - 20, y - 15) < 6 ? 1.0f : 0.0f;
      for (int c = 0; c < 4; ++c) whole.at(x, y, c) = static_cast<float>((7 * x + 13 * y + 5 * c) % 17);
    }
  constexpr int kLeft = 10, kTop = 5;
  ImageF part(20, 20, 4);
  for (int y = 0; y < 20; ++y) std::copy_n(whole.pixel(kLeft, kTop + y), 80, part.row(y));
  fill_edges(safe, 0, 0, whole);
  fill_edges(safe, kLeft, kTop, part);
  for (int y = 0; y < 20; ++y)
    for (int i = 0; i < 80; ++i) EXPECT_EQ(part.row(y)[i], whole.pixel(kLeft, kTop + y)[i]);
}

TEST(EdgeFill, AtTheImagesBorderAndWithNothingSafeNothingGoesWrong) {
  ImageF safe(4, 3, 1), pixels(4, 3, 3, 0.5f);
  fill_edges(safe, 0, 0, pixels);
  EXPECT_EQ(pixels, ImageF(4, 3, 3, 0.5f));
  safe.at(0, 0) = 1;
  for (int c = 0; c < 3; ++c) pixels.at(0, 0, c) = kColour[c];
  fill_edges(safe, 0, 0, pixels);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixels.at(x, y, c), x <= 2 ? kColour[c] : 0.5f, 1e-6f);
}

}  // namespace
}  // namespace sheen
