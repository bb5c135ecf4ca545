// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/budget.h"

#include <gtest/gtest.h>

#include "common/errors.h"
#include "reconstructor/reconstruction.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/expect_error.h"

namespace sheen {
namespace {

std::vector<Capture> glossy_captures(int count) {
  const analytic::Scene scene{square_object().surface, analytic::two_terms(0.2)};
  return captures(scene, analytic::eyes(count, 0.5, 0.55));
}

TEST(Tolerance, IsARelativeErrorOrDecibels) {
  EXPECT_DOUBLE_EQ(parse_tolerance("0.01"), 0.01);
  EXPECT_DOUBLE_EQ(parse_tolerance("40dB"), 0.01);
  EXPECT_DOUBLE_EQ(parse_tolerance("0"), 0);
  for (const char* wrong : {"", "1", "-0.1", "40db", "0.01x", "nan", "-3dB", "dB"})
    expect_error<ConfigError>([&] { parse_tolerance(wrong); }, {"--tolerance", wrong, "0.01", "40dB"});
}

TEST(EffortLadder, EveryRungCostsLessThanTheOneBefore) {
  const auto ladder = effort_ladder();
  EXPECT_EQ(ladder[0].cost, 1);
  EXPECT_EQ(ladder[0].map_scale, 1);
  for (std::size_t r = 1; r < ladder.size(); ++r) EXPECT_LT(ladder[r].cost, ladder[r - 1].cost);
}

TEST(EffortControl, ChoosesTheFirstRungThatKeepsTheBudget) {
  const EffortControl control(33);
  EXPECT_EQ(control.choose_rung(10, 0, 0), 0);
  EXPECT_EQ(control.choose_rung(10, 0, 2), 2) << "no finer than memory allows";
  const int slowest = control.choose_rung(1e6, 0, 0);
  EXPECT_LE(effort_ladder()[slowest].loss_db, 0.2) << "what follows costs more than it saves";
  EXPECT_GT(effort_ladder()[slowest + 1].loss_db, 0.2);
  const int between = control.choose_rung(50, 0, 0);
  EXPECT_GT(between, 0);
  EXPECT_LE(50 * effort_ladder()[between].cost, 33);
  EXPECT_GT(50 * effort_ladder()[between - 1].cost, 0.9 * 33);
}

TEST(EffortControl, DoesLessWhenImagesTakeTooLongAndMoreWhenThereIsRoom) {
  EffortControl control(33);
  control.set_rung(0);
  std::uint64_t image = 0;
  for (; image < 30; ++image) control.observe(image, 30);
  EXPECT_EQ(control.share(image), 1) << "within the budget nothing changes";
  for (; image < 40; ++image) control.observe(image, 60);
  const double less = control.share(image);
  EXPECT_LT(less, 0.5);
  EXPECT_EQ(control.share(29), 1) << "what was decided for earlier images stays";
  for (; image < 200; ++image) control.observe(image, 5);
  EXPECT_EQ(control.share(image), 1);
}

TEST(EffortControl, TheRecordGivesTheSameSharesAgain) {
  EffortControl first(33);
  first.set_rung(3);
  for (std::uint64_t image = 0; image < 100; ++image) first.observe(image, image < 50 ? 50 : 10);
  EffortControl second(33, first.record(), 100);
  EXPECT_EQ(second.rung(), 3);
  for (std::uint64_t image = 0; image < 100; ++image) {
    second.observe(image, 1e9);  // however long they take this time
    EXPECT_EQ(second.share(image), first.share(image)) << image;
  }
  EXPECT_EQ(second.record(), first.record());
  for (const char* wrong : {"x", "-1", "99", "1 3", "1 3:", "1 3:99", "1 a:1", "1 3:1 x"})
    expect_error<ConfigError>([&] { EffortControl(33, wrong, 5); }, {"record", wrong});
}

TEST(Budget, OneThatCannotHoldLeavesRingsOutAndTheRecordReproducesTheModel) {
  const std::vector<Capture> images = glossy_captures(40);
  const SurfaceLightFieldOptions options = plain_options();
  Reconstruction hurried(*square_object().mesh, options);
  hurried.keep_within({.image_ms = 1e-9});  // no machine holds it, so what happens does not hang on its speed
  for (const Capture& image : images) hurried.ingest(image);
  EXPECT_EQ(hurried.effort().rung, EffortControl(1e-9).choose_rung(1, 0, 0));
  EXPECT_LT(hurried.effort().share, 0.2);
  EXPECT_GT(hurried.rings().left_out, hurried.rings().updated / 4);
  EXPECT_EQ(hurried.counts().accepted, images.size());
  EXPECT_EQ(hurried.counts().received, images.size());

  Reconstruction again(*square_object().mesh, options);
  again.keep_within({.image_ms = 1e9}, hurried.effort_record(), images.size());
  for (const Capture& image : images) again.ingest(image);
  expect_same_rings(*hurried.snapshot(), *again.snapshot());
}

TEST(Budget, OneThatHoldsChangesNothing) {
  const std::vector<Capture> images = glossy_captures(12);
  Reconstruction free(*square_object().mesh, plain_options()), within(*square_object().mesh, plain_options());
  within.keep_within({.image_ms = 1e9});
  for (const Capture& image : images) {
    free.ingest(image);
    within.ingest(image);
  }
  expect_same_rings(*free.snapshot(), *within.snapshot());
  EXPECT_EQ(within.effort(), Reconstruction::Effort{});
  EXPECT_EQ(within.rings().left_out, 0u);
}

TEST(Memory, TheBoundHoldsWhateverComes) {
  SurfaceLightFieldOptions options = plain_options();
  options.ring.factor.tolerance = 0;  // all the terms that there may be
  const std::vector<Capture> images = glossy_captures(90);
  const Object object = square_object();
  const Mesh& mesh = *object.mesh;
  const double bound = largest_bytes(mesh, images[0], options);
  Reconstruction all(mesh, options);
  for (const Capture& image : images) all.ingest(image);
  EXPECT_LE(static_cast<double>(all.model().bytes()), bound);
  EXPECT_GT(static_cast<double>(all.model().bytes()), 0.2 * bound) << "a bound that says something";
}

TEST(Memory, TheRingsAreCutDownAfterAnyImageThatWouldExceedIt) {
  SurfaceLightFieldOptions options = plain_options();
  options.ring.factor = {.max_rank = 24, .tolerance = 0};
  const std::vector<Capture> images = glossy_captures(90);
  const Object object = square_object();
  Reconstruction free(*object.mesh, options), bounded(*object.mesh, options);
  for (const Capture& image : images) free.ingest(image);
  const auto full = static_cast<double>(free.model().bytes());
  bounded.keep_within({.bytes = 0.6 * full});
  for (const Capture& image : images) {
    bounded.ingest(image);
    ASSERT_LE(static_cast<double>(bounded.model().bytes()), 0.6 * full) << bounded.counts().received;
  }
  EXPECT_LT(bounded.model().options().ring.factor.terms_kept(), options.ring.factor.terms_kept());
  EXPECT_GT(static_cast<double>(bounded.model().bytes()), 0.3 * full) << "no smaller than need be";
}

TEST(Memory, WhatWasCutDownIsAFunctionOfTheCaptures) {
  SurfaceLightFieldOptions options = plain_options();
  options.ring.factor = {.max_rank = 24, .tolerance = 0};
  const std::vector<Capture> images = glossy_captures(60);
  Reconstruction once(*square_object().mesh, options), watched(*square_object().mesh, options);
  for (Reconstruction* r : {&once, &watched}) r->keep_within({.bytes = 4e5});
  for (const Capture& image : images) once.ingest(image);
  for (int turn = 0; turn < 2; ++turn) {  // the second time as after an image was taken back
    watched.restart();
    for (const Capture& image : images) {
      watched.ingest(image);
      watched.snapshot();
    }
    expect_same_rings(*once.snapshot(), *watched.snapshot());
  }
  EXPECT_LT(once.model().options().ring.factor.terms_kept(), options.ring.factor.terms_kept());
}

}  // namespace
}  // namespace sheen
