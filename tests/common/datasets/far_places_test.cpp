// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstring>

#include "common/datasets/colmap.h"
#include "common/datasets/light_list.h"
#include "common/datasets/transforms_json.h"
#include "support/expect_error.h"

namespace sheen {
namespace {

std::string transforms(const std::string& x, const std::string& more = "") {
  return R"({"w": 8, "h": 6, "fl_x": 9, "frames": [{"file_path": "a.png", "transform_matrix": [[1, 0, 0, )" + x +
         "], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]" + more + "}]}";
}

const ImageFiles kAnyFile{[](const std::string& name) { return std::filesystem::path(name); }, {}};

TEST(FarPlaces, OfCamerasAreRefusedByAllDescriptions) {
  EXPECT_EQ(parse_transforms("t.json", transforms("1e9"), kAnyFile).size(), 1u);
  for (const std::string far : {"1e19", "-1.1e9", "1e300"}) {
    expect_error([&] { parse_transforms("t.json", transforms(far), kAnyFile); },
                 {"t.json", "frame 0 (a.png)", "transform_matrix", "10^9 m"});
    ColmapImage image = parse_colmap_images_text("images.txt", "1 1 0 0 0 0 " + far + " 0 1 a.png\n\n").front();
    expect_error<Error>([&] { colmap_pose(image); }, {"translation", "10^9 m"});
  }
}

TEST(FarPlaces, OfLightsAreRefusedByAllDescriptions) {
  expect_error([] { parse_transforms("t.json", transforms("0", ", \"light_position\": [0, 1e19, 0]"), kAnyFile); },
               {"t.json", "frame 0", "light_position", "10^9 m"});
  expect_error([] { parse_light_list("a.lp", "1 positions\na 0 0 1e19\n"); }, {"a.lp", "line 2"});
}

}  // namespace
}  // namespace sheen
