// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/light_figures.h"

#include <gtest/gtest.h>

namespace sheen {
namespace {

constexpr LightFigureOptions kSmall{.width = 72, .height = 54, .lamps = 3};

TEST(LightFigures, KeepTheTolerance) {
  const Figure figure = figure_undersampling(kSmall);
  EXPECT_EQ(figure.number, 5);
  EXPECT_TRUE(figure.holds) << figure.ours;
  const PlotSeries& lit = figure.plots.at(0).plot.series.at(0);
  ASSERT_EQ(lit.y.size(), 4u);
  EXPECT_GT(lit.y[0], 1) << "there is something to be seen";
  EXPECT_LE(lit.y[0], 16);
  for (std::size_t i = 1; i < lit.y.size(); ++i) EXPECT_GT(lit.y[i], lit.y[i - 1]);
  EXPECT_GT(lit.y[2], 16);
  const ImageU8& pictures = figure.pictures.at(0).image;
  EXPECT_EQ(pictures.width(), 5 * kSmall.width);
  EXPECT_EQ(pictures.height(), 2 * kSmall.height);
}

TEST(LightFigures, EachPixelHasAnIntervalOfItsOwn) {
  const Figure figure = figure_exposure_curves(kSmall);
  EXPECT_TRUE(figure.holds) << figure.ours;
  ASSERT_EQ(figure.plots.at(0).plot.series.size(), 2u);
}

}  // namespace
}  // namespace sheen
