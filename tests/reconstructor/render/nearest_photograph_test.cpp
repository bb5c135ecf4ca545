// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/nearest_photograph.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

Eigen::Vector3d eye_at(double elevation_deg, double distance) {
  const double up = elevation_deg * M_PI / 180;
  return distance * Eigen::Vector3d(std::cos(up), 0, std::sin(up));
}

TEST(NearestPhotograph, IsToldInDegreesSeenFromTheObject) {
  const Object object = sphere_object();
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures({object.surface, analytic::two_terms(0.1)}, {eye_at(0, 0.5), eye_at(20, 0.5)}));
  const auto snapshot = model.snapshot();
  for (const double distance : {0.3, 0.5, 2.0}) {
    EXPECT_NEAR(nearest_photograph_deg(*snapshot, eye_at(54, distance)), 34, 0.5);
    EXPECT_EQ(no_photograph_note(*snapshot, eye_at(54, distance)),
              "no photograph from here: the nearest is 34 degrees away");
    EXPECT_EQ(no_photograph_note(*snapshot, eye_at(34, distance)), "");
    EXPECT_EQ(no_photograph_note(*snapshot, eye_at(20, distance)), "");
  }
  EXPECT_NEAR(nearest_photograph_deg(*snapshot, eye_at(190, 0.5)), 170, 0.5);
}

TEST(NearestPhotograph, OfAModelWithoutImagesNothingIsSaid) {
  SurfaceLightField model(sphere_object().mesh, plain_options());
  EXPECT_TRUE(std::isnan(nearest_photograph_deg(*model.snapshot(), {1, 0, 0})));
  EXPECT_EQ(no_photograph_note(*model.snapshot(), {1, 0, 0}), "");
}

}  // namespace
}  // namespace sheen
