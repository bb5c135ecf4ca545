// SPDX-License-Identifier: Apache-2.0
#include "common/plot/heat_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/base/files.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using ::testing::HasSubstr;

TEST(HeatMap, IsATableAScriptAndAPicture) {
  const TempFolder folder;
  const HeatMap map{.title = "It's a map",
                    .value = "error, px",
                    .width = 101,
                    .height = 51,
                    .columns = 3,
                    .rows = 2,
                    .values = {0, 1, 2, 3, NAN, 5},
                    .points = {{10, 20}}};
  const PlotFiles files = write_heat_map(map, folder.path() / "map");
  EXPECT_EQ(read_file(folder.path() / "map.csv"),
            "x,y,\"error, px\"\n0,0,0\n50,0,1\n100,0,2\n0,50,3\n50,50,NaN\n100,50,5\n");
  const std::string script = read_file(folder.path() / "map.gnuplot");
  EXPECT_THAT(script, HasSubstr("set title 'It''s a map'"));
  EXPECT_THAT(script, HasSubstr("set yrange [50.5:-0.5]"));  // the first row on top
  if (files != PlotFiles::kDrawn) GTEST_SKIP() << kInstallGnuplot;
  EXPECT_THAT(read_file(folder.path() / "map.svg"), HasSubstr("error, px"));
}

}  // namespace
}  // namespace sheen
