// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/photographs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/image/color.h"
#include "common/image/image_metrics.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/plain_model.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using analytic::Scene;
using Views = std::vector<Rigid3>;

Camera camera() {
  return {.width = 120, .height = 90, .fx = 170, .fy = 170, .cx = 59.5, .cy = 44.5};
}

/// Encoded value 0.5 + 0.3 times the x of the direction to the eye, everywhere the same.
Scene leaning_scene() {
  return {analytic::square(0.1, 0), analytic::encoded([](const Eigen::Vector3d&, const Eigen::Vector3d& d) {
            return Eigen::Vector3d(Eigen::Vector3d::Constant(0.5 + 0.3 * d.x()));
          })};
}

/// A texture that changes with the direction, within 0..1.
analytic::Radiance leaning_texture() {
  return analytic::encoded([](const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
    return Eigen::Vector3d(analytic::waves(p, 0.05) + Eigen::Vector3d::Constant(0.2 * d.x()));
  });
}

class Photographs : public ::testing::Test {
 protected:
  void take(const Scene& scene, const Views& poses) {
    photographs = std::make_shared<PhotographSet>(mesh, VisibilityOptions{});
    for (const Rigid3& pose : poses) {
      const Capture capture = analytic::capture(scene, camera(), pose);
      photographs->add(capture, analytic::picture(scene, camera(), pose), visibility.look(capture.camera, pose, {}));
    }
    nearest = PhotographSet::nearest_photograph(photographs, nothing);
    lumigraph = PhotographSet::unstructured_lumigraph(photographs, nothing);
  }
  /// Encoded red at the square's middle for an eye.
  float middle(const Appearance& model, const Eigen::Vector3d& eye) const {
    return srgb_encode(model.shader_for({eye})->shade(kMiddle, 0, 1).rgb.x());
  }
  static Eigen::Vector3d eye_at(double degrees, double distance = 0.5) {
    const double a = degrees * M_PI / 180;
    return distance * Eigen::Vector3d(std::sin(a), 0, std::cos(a));
  }
  static Rigid3 from(double degrees) { return look_at(eye_at(degrees), {0, 0, 0}, {0, 1, 0}); }
  static double seen_from(double degrees) { return 0.5 + 0.3 * std::sin(degrees * M_PI / 180); }

  static constexpr std::uint32_t kMiddle = 10;  // its corner 2 is the square's centre
  std::shared_ptr<const Mesh> mesh = std::make_shared<Mesh>(square_mesh(0.1f, 0, 4));
  std::shared_ptr<const Appearance> nothing = std::make_shared<testing::PlainModel>(*mesh, Eigen::Vector3f(7, 8, 9));
  MapLayout maps{std::vector<std::uint8_t>(mesh->triangles.size(), 8)};
  SampleVisibility visibility{*mesh, maps, {}};
  RayPainter painter{*mesh};
  std::shared_ptr<PhotographSet> photographs;
  std::shared_ptr<const Appearance> nearest, lumigraph;
};

constexpr float kGreyLevel = 1.0f / 255;

TEST_F(Photographs, AViewOfTheSetIsShownAsItWasTaken) {
  const Scene scene{analytic::square(0.1, 0), leaning_texture()};
  const Views poses{from(-40), from(-20), from(3), from(15), from(30), from(45)};
  take(scene, poses);
  for (const Rigid3& pose : {poses[0], poses[2], poses[5]}) {
    const ImageF truth = analytic::picture(scene, camera(), pose);
    for (const auto& model : {nearest, lumigraph}) {
      const PaintedView painted = painter.paint(*model, camera(), pose);
      const ImageU8 inside = erode(painted.coverage, 4);  // at the rim other photographs step in
      std::size_t compared = 0;
      for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 120; ++x) {
          if (inside.at(x, y) == 0) continue;
          ++compared;
          for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(srgb_encode(painted.beauty.at(x, y, c)), srgb_encode(truth.at(x, y, c)), kGreyLevel);
        }
      EXPECT_GT(compared, 2000u);
    }
  }
}

TEST_F(Photographs, ADiffuseSceneLooksTheSameToAll) {
  const Scene scene{analytic::square(0.1, 0), analytic::diffuse(0.2)};
  take(scene, {from(-40), from(-20), from(3), from(15), from(30), from(45)});
  const Rigid3 pose = from(8);
  const ImageF truth = analytic::picture(scene, camera(), pose);
  for (const auto& model : {nearest, lumigraph}) {
    const PaintedView painted = painter.paint(*model, camera(), pose);
    for (int y = 0; y < 90; ++y)
      for (int x = 0; x < 120; ++x)
        if (painted.coverage.at(x, y) == 255)
          ASSERT_NEAR(srgb_encode(painted.beauty.at(x, y, 1)), srgb_encode(truth.at(x, y, 1)), 2 * kGreyLevel);
  }
}

TEST_F(Photographs, TheGroundDoesNotBleedInAtTheRim) {
  take(leaning_scene(), {from(0)});  // on a glaring ground
  std::size_t rim = 0;
  for (int i = 0; i < 400; ++i) {  // along the rim's inner side; 340 px a metre: half a pixel to three from the edge
    const Eigen::Vector3d p(0.0985 - 0.0075 * (i % 5) / 4, -0.09 + 0.18 * i / 399, 0);
    Eigen::Vector3f encoded;
    std::uint32_t triangle = 0;
    if (!photographs->blend(triangle, p, eye_at(0), 1, encoded)) continue;
    ++rim;
    const double truth = 0.5 + 0.3 * (eye_at(0) - p).normalized().x();
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(encoded[c], truth, 2 * kGreyLevel) << p.transpose();
  }
  EXPECT_GT(rim, 150u);
}

TEST_F(Photographs, AnotherSurfaceDoesNotBleedInAtItsEdge) {
  // A white square floats over a dark one: 425 px a metre above, 340 px a metre below.
  const auto both = std::make_shared<Mesh>(joined(square_mesh(0.1f, 0, 4), square_mesh(0.03f, 0.1f, 1)));
  MapLayout with_floating(std::vector<std::uint8_t>(both->triangles.size(), 8));
  SampleVisibility looker(*both, with_floating, {});
  photographs = std::make_shared<PhotographSet>(both, VisibilityOptions{});
  const auto level = [](const Eigen::Vector3d& p) { return p.z() > 0.05 ? 1.0 : 0.2; };
  const Scene scene{analytic::nearest_of(analytic::square(0.1, 0), analytic::square(0.03, 0.1)),
                    analytic::encoded([&](const Eigen::Vector3d& p, const Eigen::Vector3d&) {
                      return Eigen::Vector3d(Eigen::Vector3d::Constant(level(p)));
                    })};
  const Capture capture = analytic::capture(scene, camera(), from(0));
  photographs->add(capture, analytic::picture(scene, camera(), from(0)), looker.look(capture.camera, from(0), {}));
  const std::uint32_t floating = static_cast<std::uint32_t>(both->triangles.size() - 1);
  std::size_t seen[2] = {0, 0};
  for (int i = 0; i < 2000; ++i) {  // the floating edge covers the floor at 0.0375 from the middle
    const double along = -0.02 + 0.04 * (i / 5) / 399, away = 0.001 + 0.0017 * (i % 5);
    for (const Eigen::Vector3d& p :
         {Eigen::Vector3d(0.03 - away, along, 0.1), Eigen::Vector3d(0.0375 + away, along, 0)}) {
      Eigen::Vector3f encoded;
      if (!photographs->blend(p.z() > 0 ? floating : 0, p, eye_at(0), 1, encoded)) continue;
      ++seen[p.z() > 0];
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(encoded[c], level(p), kGreyLevel) << p.transpose();
    }
  }
  EXPECT_GT(std::min(seen[0], seen[1]), 1000u);
}

TEST_F(Photographs, TheNearestIsTheOneOfTheLeastAngle) {
  take(leaning_scene(), {from(-30), from(0), from(20), from(40)});
  EXPECT_NEAR(middle(*nearest, eye_at(12)), seen_from(20), kGreyLevel);
  EXPECT_NEAR(middle(*nearest, eye_at(8)), seen_from(0), kGreyLevel);
  EXPECT_NEAR(middle(*nearest, eye_at(60, 3)), seen_from(40), kGreyLevel);
}

TEST_F(Photographs, TheLumigraphsWeightsAreBuehlers) {
  const std::vector<double> at{-30, -10, 5, 20, 50};
  take(leaning_scene(), {from(at[0]), from(at[1]), from(at[2]), from(at[3]), from(at[4])});
  const double eye = 12;  // angles 42, 22, 7, 8, 38: the four nearest fade towards the fifth, 42
  double sum = 0, total = 0;
  for (std::size_t j = 1; j < at.size(); ++j) {
    const double angle = std::abs(at[j] - eye), weight = (1 - angle / 42) / angle;
    sum += weight * seen_from(at[j]);
    total += weight;
  }
  EXPECT_NEAR(middle(*lumigraph, eye_at(eye)), sum / total, kGreyLevel);
}

TEST_F(Photographs, OneThatDoesNotShowThePointTakesNoPart) {
  // A second square hides the middle from the first photograph, which is the eye's own.
  const auto both = std::make_shared<Mesh>(joined(square_mesh(0.1f, 0, 4), square_mesh(0.02f, 0.2f, 1)));
  MapLayout with_blind(std::vector<std::uint8_t>(both->triangles.size(), 8));
  SampleVisibility looker(*both, with_blind, {});
  photographs = std::make_shared<PhotographSet>(both, VisibilityOptions{});
  Scene scene = leaning_scene();
  scene.surface = analytic::nearest_of(scene.surface, analytic::square(0.02, 0.2));
  for (const double degrees : {0.0, 30.0}) {
    const Capture capture = analytic::capture(scene, camera(), from(degrees));
    photographs->add(capture, analytic::picture(scene, camera(), from(degrees)),
                     looker.look(capture.camera, from(degrees), {}));
  }
  for (const auto& model : {PhotographSet::nearest_photograph(photographs, nothing),
                            PhotographSet::unstructured_lumigraph(photographs, nothing)}) {
    EXPECT_NEAR(middle(*model, eye_at(0)), seen_from(30), kGreyLevel);
  }
}

TEST_F(Photographs, WhatNoneShowsIsShadedByTheOtherModelAndMarked) {
  take(leaning_scene(), {look_at({0.05, 0, 0.02}, {0.2, 0, 0.02}, {0, 0, 1})});
  EXPECT_EQ(photographs->size(), 0u);
  const SurfaceSample sample = lumigraph->shader_for({{0, 0, 1}})->shade(3, 0.2f, 0.3f);
  EXPECT_EQ(sample.state, SampleState::kUnseen);
  EXPECT_EQ(sample.rgb, Eigen::Vector3f(7, 8, 9));
}

}  // namespace
}  // namespace sheen
