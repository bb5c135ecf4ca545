// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/lumigraph_figures.h"

#include <gtest/gtest.h>

#include <string>

namespace sheen {
namespace {

/// Five lights, as far apart as they may be for shadows to overlap, and views that suffice for depth.
const StillLife& scene() {
  static const StillLife scene({.lights = 5, .columns = 3, .rows = 3, .width = 160, .height = 120}, nullptr);
  return scene;
}
const ShadowRow& row() {
  static const ShadowRow row = shadows_between(scene(), 1);
  return row;
}

double number(const std::string& text) {
  return std::stod(text);
}

TEST(LumigraphFigures, RowsBeginAndEndInCapturedLights) {
  ASSERT_EQ(row().places.size(), 9u);
  EXPECT_EQ(row().places.front(), 1);
  EXPECT_EQ(row().places.back(), 2);
  const IntrinsicView& view = *scene().model->data()->views[4];
  for (const auto& [k, light] : {std::pair(0u, 1u), std::pair(8u, 2u)}) {
    EXPECT_EQ(row().truth[k], row().linear[k]) << "linear interpolation is exact there";
    for (std::size_t i = 0; i < view.arrives[light].size(); ++i)
      ASSERT_EQ(row().lumigraph[k].data()[i], 255 - view.arrives[light].data()[i]);
  }
}

TEST(LumigraphFigures, ShadowsAreBetterThanByLinearInterpolation) {
  const Figure shapes = figure_shadow_shapes(row()), difference = figure_shadow_difference(row());
  EXPECT_TRUE(shapes.holds) << shapes.ours;
  EXPECT_TRUE(difference.holds) << difference.ours;
  EXPECT_EQ(shapes.number, 9);
  EXPECT_EQ(difference.number, 10);
  const Figure::Table& along = shapes.tables.at(0);
  ASSERT_EQ(along.rows.size(), 9u);
  for (const std::vector<std::string>& line : difference.tables.at(0).rows) {
    const double missing = number(line[1]) / 100, excess = number(line[2]) / 100;
    EXPECT_NEAR(number(line[3]), (1 - missing) / (1 + excess), 2e-3) << line[0];
  }
  EXPECT_NEAR(number(difference.tables[0].rows[0][3]), number(along.rows[4][1]), 1e-9);
}

TEST(LumigraphFigures, MasksAreMovedAsTheDepthMapsShadows) {
  const Figure figure = figure_moved_masks(row());
  EXPECT_EQ(figure.number, 7);
  // The paper's way is no better than linear interpolation in pictures this small: what is said must be what was found.
  const Figure::Table& table = figure.tables.at(0);
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.rows[3][1], "1.000") << "linear interpolation of exact shadows, at a captured light";
  EXPECT_EQ(figure.holds, number(table.rows[1][2]) > number(table.rows[3][2]));
  for (const std::size_t end : {1u, 3u}) {
    EXPECT_GT(number(table.rows[1][end]), 0.5);
    EXPECT_LE(number(table.rows[1][end]), number(table.rows[2][end]) + 0.02) << "masks are moved, none is made better";
  }
  EXPECT_EQ(figure.pictures.at(0).image.width(), 3 * 160);
  EXPECT_EQ(figure.pictures.at(0).image.height(), 4 * 120);
}

TEST(LumigraphFigures, ADepthMapCastsWorseShadowsThanTheImagesShow) {
  const Figure figure = figure_depth_shadows(scene());
  EXPECT_EQ(figure.number, 8);
  EXPECT_TRUE(figure.holds) << figure.ours;
  EXPECT_EQ(figure.tables.at(0).rows.size(), 5u);
}

TEST(LumigraphFigures, PicturesAndErrorMapsSayTheSame) {
  const Figure pictures = figure_light_between(scene(), 11), errors = figure_error_maps(scene());
  EXPECT_TRUE(pictures.holds) << pictures.ours;
  EXPECT_TRUE(errors.holds) << errors.ours;
  ASSERT_EQ(pictures.tables.at(0).rows.size(), 5u) << "four places and their mean";
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) sum += number(pictures.tables[0].rows[i][1]);
  EXPECT_NEAR(number(pictures.tables[0].rows[4][1]), sum / 4, 0.01);
  EXPECT_EQ(errors.tables.at(0).rows[0][4], pictures.tables[0].rows[1][1]) << "the same place";
}

TEST(LumigraphFigures, AllLightsTogetherGiveBetterDepthThanTheBest) {
  const DepthsByLight depths =
      depths_by_light(LightRig({.lights = 3, .columns = 3, .rows = 3, .width = 160, .height = 120}));
  ASSERT_EQ(depths.on_planes.size(), 3u);
  EXPECT_EQ(depths.error(depths.truth), 0);
  EXPECT_LT(depths.error(depths.by_all), depths.least_error(depths.on_planes));
  const Figure figure = figure_merged_depth(depths);
  EXPECT_EQ(figure.number, 3);
  EXPECT_EQ(figure.tables.at(0).rows.size(), 6u) << "three lights, three ways to merge them";
}

}  // namespace
}  // namespace sheen
