// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/demand_map.h"

#include <gtest/gtest.h>

#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

TEST(DemandMap, IsFromDarkToBrightUpToWhatNearlyAllNeed) {
  const Object object = sphere_object();
  const analytic::Scene scene{object.surface, analytic::two_terms(0.1)};
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures(scene, analytic::eyes(16, 0.5, 0.1)));
  const auto snapshot = model.snapshot();
  const std::vector<SurfaceDemand> triangles = surface_demand(*snapshot);
  for (const Demand demand : kDemands) {
    const DemandMap map(*snapshot, demand);
    ASSERT_EQ(map.levels().size(), triangles.size());
    std::size_t reached = 0, beyond = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const float value = value_of(triangles[t], demand), level = map.levels()[t];
      if (triangles[t].rank == 0) {
        EXPECT_LT(level, 0) << "no image reached it";
        continue;
      }
      ++reached;
      beyond += value > map.most();
      EXPECT_FLOAT_EQ(level, std::min(1.0f, value / map.most())) << to_string(demand);
    }
    EXPECT_LE(beyond, 0.03 * static_cast<double>(reached)) << to_string(demand);
  }
}

TEST(DemandMap, ColoursAreBrighterTheMoreThereIs) {
  const auto brightness = [](float level) { return demand_colour(level).dot(Eigen::Vector3f(0.2f, 0.7f, 0.1f)); };
  for (float level = 0; level < 0.99f; level += 0.05f) EXPECT_GT(brightness(level + 0.05f), brightness(level)) << level;
  EXPECT_EQ(demand_colour(0), demand_stop(0));
  EXPECT_EQ(demand_colour(1), demand_stop(kDemandColours - 1));
}

}  // namespace
}  // namespace sheen
