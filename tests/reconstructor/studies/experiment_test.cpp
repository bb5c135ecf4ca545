// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/experiment.h"

#include <gtest/gtest.h>

#include "common/image/linear_reader.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/expect_error.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

std::vector<Capture> square_captures(int count) {
  std::vector<Capture> all = captures({square_object().surface, analytic::diffuse(0.06)}, eyes(count, 0.5, 0.55));
  for (std::size_t i = 0; i < all.size(); ++i) all[i].sequence = i + 1;
  return all;
}

Experiment load(const std::vector<Capture>& all, const ExperimentOptions& options = {}) {
  return load_experiment(
      square_object().mesh, all.size(), [&](std::size_t i) { return all[i]; }, options);
}

TEST(Experiment, HoldsOutAsBuildDoes) {
  const Experiment experiment = load(square_captures(17));
  EXPECT_EQ(experiment.training.size(), 15u);
  EXPECT_EQ(experiment.held_out.size(), 2u);
}

TEST(Experiment, ObeysWhatTheCapturesSay) {
  std::vector<Capture> all = square_captures(10);
  for (Capture& capture : all) capture.purpose = Purpose::kTraining;
  all[3].purpose = Purpose::kHeldOut;
  all[3].name = "judge";
  const Experiment experiment = load(all);
  EXPECT_EQ(experiment.training.size(), 9u);
  ASSERT_EQ(experiment.held_out.size(), 1u);
  EXPECT_EQ(experiment.held_out[0].name, "judge");
}

TEST(Experiment, LimitsTheViewsThatJudge) {
  const Experiment experiment = load(square_captures(24), {.hold_out_every = 2, .max_held_out = 3});
  EXPECT_EQ(experiment.training.size(), 12u);
  EXPECT_EQ(experiment.held_out.size(), 3u);
}

TEST(Experiment, ImagesOfOtherExposuresAreBroughtToOneLevel) {
  std::vector<Capture> all = square_captures(9);
  for (Capture& capture : all) capture.exposure.exposure_s = 0.01;
  Capture bright = all[1];
  for (std::size_t i = 0; i < bright.image.bytes.size() / sizeof(float); ++i)
    reinterpret_cast<float*>(bright.image.bytes.data())[i] *= 2;
  bright.exposure.exposure_s = 0.02;
  const ImageF expected = to_linear_rgb(all[1].image);
  all[1] = bright;
  const ImageF levelled = to_linear_rgb(load(all).training[1].image);
  ASSERT_EQ(levelled.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_NEAR(levelled.data()[i], expected.data()[i], 1e-5);
}

TEST(Experiment, WhatShowsNothingIsLeftOut) {
  std::vector<Capture> all = square_captures(9);
  all[0].pose.status = PoseStatus::kNoTags;
  all[2].pose.camera_from_object.translation = {0, 0, -5};  // looks away from it
  EXPECT_EQ(load(all, {.hold_out_every = 7}).training.size(), 6u);
  for (Capture& capture : all) capture.pose.status = PoseStatus::kNoTags;
  expect_error<Error>([&] { load(all); }, {"none of the 9 images"});
  expect_error<Error>([&] { load(square_captures(3)); }, {"no held-out view"});
}

TEST(Experiment, RandomViewpointsLieOnTheHemisphereThatTheImagesWereTakenFrom) {
  const Experiment experiment = load(square_captures(17));
  const std::vector<PosedCamera> views = random_viewpoints(experiment, 400, 3);
  ASSERT_EQ(views.size(), 400u);
  EXPECT_EQ(views, random_viewpoints(experiment, 400, 3));
  EXPECT_NE(views, random_viewpoints(experiment, 400, 4));
  int low = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const PosedCamera& view : views) {  // the images are taken 0.5 m from the origin, from all round above it
    const Eigen::Vector3d eye = camera_centre(view.camera_from_object);
    EXPECT_NEAR(eye.norm(), 0.5, 1e-6);
    EXPECT_GT(eye.z(), -0.1);
    const auto middle = view.camera.project(view.camera_from_object * Eigen::Vector3d(0, 0, 0));
    ASSERT_TRUE(middle);
    EXPECT_LT((*middle - Eigen::Vector2d(79.5, 59.5)).norm(), 1e-6);
    low += eye.z() < 0.25;
    mean += eye / 400;
  }
  // Evenly over the area: heights are uniform between 0 and the radius, and so half are below half of it.
  EXPECT_NEAR(low, 200, 50);
  EXPECT_LT((mean - Eigen::Vector3d(0, 0, 0.25)).norm(), 0.08);
}

TEST(Experiment, ARunIsTheModelThatIngestMakes) {
  const Experiment experiment = load(square_captures(9));
  const OnlineRun run = build_online(experiment.mesh, experiment.in_order(), {});
  SurfaceLightField model(experiment.mesh, {});
  for (const Capture& capture : experiment.training) model.ingest(capture);
  expect_same_patches(*run.model, *model.light_field_snapshot());
  EXPECT_EQ(run.image_ms.size(), 8u);
  EXPECT_EQ(run.bytes, model.bytes());
  EXPECT_GE(run.mean_rank, 1);
  EXPECT_GT(run.factorize_ms, 0);
  EXPECT_LT(run.factorize_ms * 8, 1e3 * run.total_s()) << "a part of it";
}

}  // namespace
}  // namespace sheen
