// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/guess_marks.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "reconstructor/render/ray_painter.h"

namespace sheen {
namespace {

/// Grey, with one state everywhere.
ImageU8 marked(std::uint8_t coverage, int channels) {
  PaintedView view;
  view.coverage = ImageU8(24, 24, 1);
  std::fill_n(view.coverage.data(), view.coverage.size(), coverage);
  ImageU8 picture(24, 24, channels);
  std::fill_n(picture.data(), picture.size(), std::uint8_t{100});
  mark_guesses(view, picture);
  return picture;
}

TEST(GuessMarks, MeasuredPartsAndTheBackgroundStay) {
  for (const std::uint8_t coverage : {kCoverageMeasured, std::uint8_t{0}})
    for (const int channels : {3, 4}) {
      const ImageU8 picture = marked(coverage, channels);
      EXPECT_TRUE(std::all_of(picture.data(), picture.data() + picture.size(), [](int v) { return v == 100; }));
    }
}

TEST(GuessMarks, ImputedPartsAreTintedEvenly) {
  const ImageU8 picture = marked(kCoverageImputed, 4);
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 24; ++x) {
      EXPECT_LT(picture.at(x, y, 0), 100) << "towards blue";
      EXPECT_GT(picture.at(x, y, 2), 130);
      EXPECT_EQ(picture.at(x, y, 2), picture.at(0, 0, 2));
      EXPECT_EQ(picture.at(x, y, 3), 100) << "alpha";
    }
}

TEST(GuessMarks, GuessesAreStriped) {
  const ImageU8 picture = marked(kCoverageUnseen, 3);
  int strong = 0;
  for (int x = 0; x < 24; ++x) {
    EXPECT_GT(picture.at(x, 0, 0), 115) << "towards purple, everywhere";
    strong += picture.at(x, 0, 0) > 150;
  }
  EXPECT_EQ(strong, 12) << "half of it in stripes";
}

}  // namespace
}  // namespace sheen
