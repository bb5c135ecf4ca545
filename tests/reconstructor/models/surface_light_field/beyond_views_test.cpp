// SPDX-License-Identifier: Apache-2.0
// What eyes see that stand where no camera stood: models of one ring of cameras, looked at from all round.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reconstructor/models/surface_light_field/files/compact_file.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "tests/reconstructor/models/beyond_views.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using namespace beyond_views;

/// A texture in which three lamps are mirrored.
analytic::Radiance glossy() {
  return analytic::encoded([](const Eigen::Vector3d& p, const Eigen::Vector3d& to_eye) {
    const Eigen::Vector3d n = p.normalized(), mirrored = 2 * n.dot(to_eye) * n - to_eye;
    double lamps = 0;
    for (const Eigen::Vector3d& lamp :
         {Eigen::Vector3d(1, 0, 1), Eigen::Vector3d(-1, 1, 0.3), Eigen::Vector3d(0, -1, 0.1)})
      lamps += std::pow(std::max(0.0, mirrored.dot(lamp.normalized())), 15);
    return Eigen::Vector3d((0.7 * analytic::waves(p, 0.05).array() + 0.35 * lamps).min(1.0));
  });
}

class BeyondViews : public ::testing::TestWithParam<Ring> {
 protected:
  void expect_calm(const ModelSnapshot& model, const std::string& kind) const {
    Walk w = walk(model, scene_, GetParam().eyes());
    ASSERT_GT(w.excess.size(), 1000u);
    EXPECT_LT(Walk::quantile(w.excess, 0.99), 12) << kind;
    EXPECT_LT(Walk::quantile(w.excess, 1), 32) << kind;
    EXPECT_LT(Walk::quantile(w.flicker, 1), 6) << kind;
  }

  Object object_ = sphere_object();
  analytic::Scene scene_{object_.surface, glossy()};
  TempFolder temp_;
};

TEST_P(BeyondViews, ColoursStayWithinWhatWasSeenAndChangeSmoothly) {
  SurfaceLightField model(object_.mesh, plain_options());
  ingest_all(model, captures(scene_, GetParam().eyes()));
  const auto live = model.light_field_snapshot()->filled();
  expect_calm(*live, "live");
  live->save(temp_.path() / "folder", {}, {});
  expect_calm(*load_model(temp_.path() / "folder"), "saved");
  const auto small = live->compressed({.loss_db = 0.1}).snapshot;
  small->save(temp_.path() / "file", {}, {});
  expect_calm(*load_compact(temp_.path() / "file"), "small");
}

INSTANTIATE_TEST_SUITE_P(Rings, BeyondViews,
                         ::testing::Values(Ring{"OneCamera", 1, 20}, Ring{"ThreeCameras", 3, 20},
                                           Ring{"SixCameras", 6, 20}, Ring{"Low", 48, 5}, Ring{"High", 60, 60},
                                           Ring{"Middle", 24, 20}, Ring{"ShortArc", 12, 40, 60}),
                         [](const auto& ring) { return ring.param.name; });

}  // namespace
}  // namespace sheen
