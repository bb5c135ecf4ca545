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
