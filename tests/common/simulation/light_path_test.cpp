// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/light_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

TEST(LightPath, OfADomeGoesRoundAndUp) {
  const std::vector<LightState> path = light_path("dome", 60);
  ASSERT_EQ(path.size(), 60u);
  double nearest = 1;
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(path[i].kind, LightKind::kPoint);
    EXPECT_NEAR(path[i].position.norm(), 0.9, 1e-12);
    EXPECT_GT(path[i].position.z(), 0.9 * std::sin(14.9 * M_PI / 180));
    for (std::size_t k = 0; k < i; ++k) nearest = std::min(nearest, (path[i].position - path[k].position).norm());
  }
  EXPECT_GT(nearest, 0.05) << "the dome is covered about evenly";
}

TEST(LightPath, OfAPlaneGoesToAndFro) {
  const std::vector<LightState> path = light_path("plane", 9);
  ASSERT_EQ(path.size(), 9u);
  EXPECT_EQ(path[0].position, Eigen::Vector3d(-0.5, -0.5, 0.9));
  EXPECT_EQ(path[2].position, Eigen::Vector3d(0.5, -0.5, 0.9));
  EXPECT_EQ(path[3].position, Eigen::Vector3d(0.5, 0, 0.9));
  EXPECT_EQ(path[8].position, Eigen::Vector3d(0.5, 0.5, 0.9));
}

TEST(LightPath, OfAListPassesItsPlaces) {
  const TempFolder temp;
  const auto file = temp.write("path.lp", "3\na 0 0 0.5\nb 0.4 0 0.5\nc 0.4 0.8 0.5\n");
  const std::vector<LightState> path = light_path(file, 5);
  ASSERT_EQ(path.size(), 5u);
  EXPECT_EQ(path[1].position, Eigen::Vector3d(0.2, 0, 0.5));
  EXPECT_EQ(path[2].position, Eigen::Vector3d(0.4, 0, 0.5));
  EXPECT_EQ(path[4].position, Eigen::Vector3d(0.4, 0.8, 0.5));
  EXPECT_EQ(light_path(file, 1)[0].position, Eigen::Vector3d(0, 0, 0.5));
}

TEST(LightPath, RefusesWhatIsNone) {
  const TempFolder temp;
  expect_error<ConfigError>([] { light_path("spiral", 5); }, {"spiral", "dome, plane"});
  const auto far = temp.write("far.lp", "1\na 0 0 1\n");
  expect_error<ConfigError>([&] { light_path(far, 5); }, {"far.lp", "positions in metres"});
  expect_error([&] { light_path((temp.path() / "none.lp").string(), 5); }, {"none.lp"});
}

}  // namespace
}  // namespace sheen
