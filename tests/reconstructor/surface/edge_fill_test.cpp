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

TEST(EdgeFill, AColourIsContinuedByOnePixelAndNotFurther) {
  ImageU8 from_edge(50, 40, 1);
  ImageF pixels(50, 40, 3);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 50; ++x)
      if (distance_from_disc(x, y) == 0) {
        from_edge.at(x, y) = std::hypot(x - 24, y - 19) < 9 ? 2 : 1;
        std::copy_n(kColour, 3, pixels.pixel(x, y));
      }
  fill_edges(from_edge, 0, 0, pixels);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 50; ++x)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(pixels.at(x, y, c), distance_from_disc(x, y) <= 1 ? kColour[c] : 0, 1e-6f) << x << ' ' << y;
}

TEST(EdgeFill, TakesTheMeanOfWhatItTouchesAndLeavesOthersAlone) {
  // (2, 2) and (4, 2) touch no edge; those between them and round them do.
  ImageU8 from_edge(7, 5, 1);
  ImageF pixels(7, 5, 1, 100.0f);
  from_edge.at(2, 2) = from_edge.at(4, 2) = 1;
  pixels.at(2, 2) = 3;
  pixels.at(4, 2) = 5;
  fill_edges(from_edge, 0, 0, pixels);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) {
      const bool row = y >= 1 && y <= 3;  // columns 1 and 2 touch (2, 2) only, 4 and 5 touch (4, 2) only, 3 both
      const float expected = !row || x < 1 || x > 5 ? 100 : x <= 2 ? 3 : x == 3 ? 4 : 5;
      EXPECT_EQ(pixels.at(x, y), expected) << x << ' ' << y;
    }
}

TEST(EdgeFill, APartOfTheImageIsFilledAsTheWholeIs) {
  ImageU8 from_edge(40, 30, 1);
  ImageF whole(40, 30, 4);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) {
      from_edge.at(x, y) = std::hypot(x - 20, y - 15) < 6;
      for (int c = 0; c < 4; ++c) whole.at(x, y, c) = static_cast<float>((7 * x + 13 * y + 5 * c) % 17);
    }
  constexpr int kLeft = 10, kTop = 5;
  ImageF part(20, 20, 4);
  for (int y = 0; y < 20; ++y) std::copy_n(whole.pixel(kLeft, kTop + y), 80, part.row(y));
  fill_edges(from_edge, 0, 0, whole);
  fill_edges(from_edge, kLeft, kTop, part);
  for (int y = 0; y < 20; ++y)
    for (int i = 0; i < 80; ++i) EXPECT_EQ(part.row(y)[i], whole.pixel(kLeft, kTop + y)[i]);
}

TEST(EdgeFill, AtTheImagesBorderAndWithNothingToContinueNothingGoesWrong) {
  ImageU8 from_edge(4, 3, 1);
  ImageF pixels(4, 3, 3, 0.5f);
  fill_edges(from_edge, 0, 0, pixels);
  EXPECT_EQ(pixels, ImageF(4, 3, 3, 0.5f));
  from_edge.at(0, 0) = 1;
  for (int c = 0; c < 3; ++c) pixels.at(0, 0, c) = kColour[c];
  fill_edges(from_edge, 0, 0, pixels);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixels.at(x, y, c), x <= 1 && y <= 1 ? kColour[c] : 0.5f, 1e-6f);
}

}  // namespace
}  // namespace sheen
