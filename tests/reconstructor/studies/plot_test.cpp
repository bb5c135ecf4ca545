// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/figure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "common/base/files.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using testing::HasSubstr;
using testing::Not;

Plot small_plot() {
  Plot plot{.title = "Rank's price & worth", .x = {.label = "rank"}, .y = {.label = "error, relative", .log = true}};
  plot.series.push_back({.name = "online", .x = {1, 2, 4}, .y = {0.5, 0.25, 0.0625}, .labels = {"", "a \"b\"", "c"}});
  plot.series.push_back({.name = "batch, SVD", .x = {1, 2}, .y = {0.4, std::numeric_limits<double>::quiet_NaN()}});
  plot.levels.push_back({"the paper", 0.1});
  return plot;
}

TEST(Plot, TheTableHoldsEveryPoint) {
  EXPECT_EQ(plot_csv(small_plot()),
            "series,rank,\"error, relative\",label\n"
            "online,1,0.5,\nonline,2,0.25,\"a \"\"b\"\"\"\nonline,4,0.0625,c\n"
            "\"batch, SVD\",1,0.4,\n\"batch, SVD\",2,nan,\nthe paper,,0.1,\n");
}

TEST(Plot, TablesAreWrittenForProgramsAndForPeople) {
  const Figure::Table table{
      "t", "caption", {"surface", "error, grey levels"}, {{"x, brushed", "3.1"}, {"turned", "4"}}};
  EXPECT_EQ(table_csv(table), "surface,\"error, grey levels\"\n\"x, brushed\",3.1\nturned,4\n");
  EXPECT_EQ(table_markdown(table),
            "| surface | error, grey levels |\n|---|---|\n| x, brushed | 3.1 |\n| turned | 4 |\n");
}

TEST(Plot, CategoriesStandInTheTableByName) {
  Plot plot{.title = "t", .x = {.label = "mesh", .categories = {"bust", "heart"}}, .y = {.label = "s"}};
  plot.series.push_back({.name = "online", .x = {0, 1}, .y = {3, 4}, .style = PlotStyle::kBars});
  EXPECT_EQ(plot_csv(plot), "series,mesh,s,label\nonline,bust,3,\nonline,heart,4,\n");
}

TEST(Plot, ErrorBarsStandInTheTableAndInTheScript) {
  Plot plot{.title = "t", .x = {.label = "images"}, .y = {.label = "dB"}};
  plot.series.push_back({.name = "guidance", .x = {1, 2}, .y = {3, 4}, .bars = {0.5, 0.25}});
  plot.series.push_back({.name = "random", .x = {1}, .y = {2}});
  EXPECT_EQ(plot_csv(plot), "series,images,dB,label,bar\nguidance,1,3,,0.5\nguidance,2,4,,0.25\nrandom,1,2,,\n");
  const TempFolder folder;
  write_plot(plot, folder.path() / "p");
  const std::string script = read_file(folder.path() / "p.gnuplot");
  EXPECT_THAT(script, HasSubstr("2 4 0.25\n"));
  EXPECT_THAT(script, HasSubstr("$series0 using 1:($2 - $3):(0):(2 * $3) with vectors nohead"));
  EXPECT_THAT(script, Not(HasSubstr("$series1 using 1:($2 - $3)")));
}

TEST(Plot, ACurveReachesAValueBetweenItsPoints) {
  const PlotSeries curve{.name = "c", .x = {2, 4, 8}, .y = {10, 20, 18}};
  EXPECT_EQ(images_to_reach(curve, 9), 2) << "no earlier point says so";
  EXPECT_EQ(images_to_reach(curve, 15), 3);
  EXPECT_EQ(images_to_reach(curve, 19), 3.8) << "the first time";
  EXPECT_TRUE(std::isnan(images_to_reach(curve, 21)));
}

TEST(Plot, ThePictureShowsTitleAxesAndSeries) {
  const TempFolder folder;
  ASSERT_EQ(write_plot(small_plot(), folder.path() / "p"), PlotFiles::kDrawn) << kInstallGnuplot;
  const std::string svg = read_file(folder.path() / "p.svg");
  for (const char* text : {"Rank's price &amp; worth", "error, relative", "rank", "online", "batch, SVD", "the paper"})
    EXPECT_THAT(svg, HasSubstr(text));
  EXPECT_EQ(read_file(folder.path() / "p.csv"), plot_csv(small_plot()));
}

TEST(Plot, WithoutGnuplotTheTableAndTheScriptAreWritten) {
  const TempFolder folder;
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", folder.path().c_str(), 1);
  const PlotFiles files = write_plot(small_plot(), folder.path() / "p");
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(files, PlotFiles::kTableOnly);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "p.svg"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "p.csv"));
  const std::string script = read_file(folder.path() / "p.gnuplot");
  EXPECT_THAT(script, HasSubstr("plot "));
  EXPECT_THAT(script, Not(HasSubstr("nan")));
  EXPECT_THAT(script, Not(HasSubstr(folder.path().string()))) << "the script is drawn where it lies";
}

TEST(Plot, AFolderThatIsNotThereIsNamed) {
  expect_error([] { write_plot(small_plot(), "/nonexistent/folder/p"); }, {"/nonexistent/folder/p.csv"});
}

}  // namespace
}  // namespace sheen
