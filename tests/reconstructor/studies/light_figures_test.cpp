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

/// Every spacing's largest error stands beside the tolerance.
TEST(LightFigures, TablesSayWhatTheTextSays) {
  const Figure figure = figure_brushed_metals(kSmall);
  EXPECT_EQ(figure.number, 7);
  EXPECT_TRUE(figure.holds) << figure.ours;
  const Figure::Table& table = figure.tables.at(0);
  ASSERT_EQ(table.rows.size(), 8u) << "two surfaces, four spacings";
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const std::vector<std::string>& row = table.rows[i];
    ASSERT_EQ(row.size(), table.columns.size());
    const PlotSeries& lit = figure.plots.at(0).plot.series.at(2 * (i / 4));
    EXPECT_NEAR(std::stod(row[3]), lit.y[i % 4], 0.006);
    EXPECT_EQ(row[4], "16");
    EXPECT_EQ(row[5], lit.y[i % 4] <= 16 ? "yes" : "no");
    EXPECT_NEAR(std::stod(row[2]) / std::stod(table.rows[4 * (i / 4)][2]), lit.x[i % 4] / 0.91, 0.02);
  }
}

TEST(LightFigures, EachPixelHasAnIntervalOfItsOwn) {
  const Figure figure = figure_exposure_curves(kSmall);
  EXPECT_TRUE(figure.holds) << figure.ours;
  ASSERT_EQ(figure.plots.at(0).plot.series.size(), 2u);
  ASSERT_EQ(figure.tables.at(0).rows.size(), 8u) << "two pixels, four spacings";
  for (const std::size_t row : {0u, 4u}) EXPECT_EQ(figure.tables[0].rows[row][5], "yes") << "at the planned spacing";
}

}  // namespace
}  // namespace sheen
