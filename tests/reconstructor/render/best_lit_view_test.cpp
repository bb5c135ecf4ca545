// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/best_lit_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

/// Round the z axis, all as high.
std::vector<Eigen::Vector3d> ring_of_eyes(int count) {
  std::vector<Eigen::Vector3d> eyes;
  for (int i = 0; i < count; ++i) {
    const double a = 2 * M_PI * i / count;
    eyes.emplace_back(0.45 * std::cos(a), 0.45 * std::sin(a), 0.2);
  }
  return eyes;
}

TEST(BestLitView, IsFromTheBrightSideAsHighAsTheOpeningView) {
  const Object object = sphere_object();
  const std::vector<Eigen::Vector3d> eyes = ring_of_eyes(8);
  for (const std::size_t lit : {1u, 4u, 6u}) {
    const Eigen::Vector3d from = eyes[lit].normalized();
    const auto radiance = analytic::encoded([&](const Eigen::Vector3d& p, const Eigen::Vector3d&) {
      return Eigen::Vector3d(Eigen::Vector3d::Constant(0.2 + 0.6 * std::max(0.0, p.normalized().dot(from))));
    });
    SurfaceLightField model(object.mesh, plain_options());
    ingest_all(model, captures({object.surface, radiance}, eyes));
    const auto snapshot = model.snapshot();
    const std::optional<OpeningView> view = best_lit_view(*snapshot);
    ASSERT_TRUE(view);
    EXPECT_GT(view->direction.dot(from), 0.999) << lit;
    EXPECT_EQ(view->up, opening_view(snapshot->cameras(), bounding_sphere(*object.mesh).centre)->up);
  }
}

TEST(BestLitView, WithoutColoursIsTheOpeningView) {
  const Object object = sphere_object();
  SurfaceLightField model(object.mesh, plain_options());
  EXPECT_FALSE(best_lit_view(*model.snapshot())) << "without cameras there is none";
}

}  // namespace
}  // namespace sheen
