// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/effort/effort_control.h"

#include <gtest/gtest.h>

#include <tuple>

#include "common/base/errors.h"
#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/models/surface_light_field/effort_levels.h"
#include "reconstructor/models/surface_light_field/memory_account.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/expect_error.h"

namespace sheen {
namespace {

constexpr int kLevels = 6;

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

TEST(MeasuredLevels, TheFirstLevelThatKeepsTheBudgetIsTakenAndNoneThatLosesTooMuch) {
  const MeasuredLevels measured{{100, 32}, {80, 31.95}, {60, 31.9}, {50, 31.81}, {40, 31.5}, {30, 31.9}};
  EXPECT_EQ(level_within(measured, 10, 0, 33), 0);
  EXPECT_EQ(level_within(measured, 10, 2, 33), 2) << "no finer than memory allows";
  EXPECT_EQ(level_within(measured, 45, 0, 33), 2) << "0.9 of the budget at 0.6 of the time";
  EXPECT_EQ(level_within(measured, 27, 2, 33), 2);
  EXPECT_EQ(level_within(measured, 1e6, 0, 33), 3) << "the next one loses half a decibel";
  EXPECT_EQ(level_reaching(measured, 31.85), 5);
  EXPECT_EQ(level_reaching(measured, 31.92), 1);
  EXPECT_EQ(level_reaching(measured, 40), 0) << "where none does, the finest";
}

TEST(EffortControl, TheNextShareUpCostsAtMostOneAndAHalfTimesAsMuch) {
  EffortControl control(1, kLevels);
  control.set_level(0);
  std::uint64_t image = 0;
  double before = 1;
  for (int step = 0; control.update_fraction(image) > 0.081; ++step) {
    ASSERT_LT(step, 100);
    for (int i = 0; i < 3; ++i, ++image) control.observe(image, 100);
    EXPECT_LE(before / control.update_fraction(image), 1.5 + 1e-9);
    EXPECT_LT(control.update_fraction(image), before);
    before = control.update_fraction(image);
  }
}

TEST(EffortControl, SettlesWhereAnImageCostsWhatItsShareDoes) {
  for (double whole_ms = 20; whole_ms < 1000; whole_ms *= 1.01)
    for (const double fixed_ms : {0.0, 2.0}) {
      EffortControl control(33, kLevels);
      control.set_level(0);
      std::uint64_t image = 0;
      const auto go_on = [&](int images) {
        for (int i = 0; i < images; ++i, ++image)
          control.observe(image, fixed_ms + control.update_fraction(image) * whole_ms);
      };
      go_on(100);
      const std::string settled = control.record();
      go_on(300);
      ASSERT_EQ(control.record(), settled) << whole_ms;
    }
}

TEST(EffortControl, DoesLessWhenImagesTakeTooLongAndMoreWhenThereIsRoom) {
  EffortControl control(33, kLevels);
  control.set_level(0);
  std::uint64_t image = 0;
  for (; image < 30; ++image) control.observe(image, 30);
  EXPECT_EQ(control.update_fraction(image), 1) << "within the budget nothing changes";
  for (; image < 40; ++image) control.observe(image, 60);
  const double less = control.update_fraction(image);
  EXPECT_LT(less, 0.5);
  EXPECT_EQ(control.update_fraction(29), 1) << "what was decided for earlier images stays";
  for (; image < 200; ++image) control.observe(image, 5);
  EXPECT_EQ(control.update_fraction(image), 1);
}

TEST(EffortControl, TheRecordGivesTheSameSharesAgain) {
  EffortControl first(33, kLevels);
  first.set_level(3);
  for (std::uint64_t image = 0; image < 100; ++image) first.observe(image, image < 50 ? 50 : 10);
  EffortControl second(33, kLevels, first.record(), 100);
  EXPECT_EQ(second.effort_level(), 3);
  for (std::uint64_t image = 0; image < 100; ++image) {
    second.observe(image, 1e9);  // however long they take this time
    EXPECT_EQ(second.update_fraction(image), first.update_fraction(image)) << image;
  }
  EXPECT_EQ(second.record(), first.record());
  for (const char* wrong : {"x", "-1", "99", "1 3", "1 3:", "1 3:99", "1 a:1", "1 3:1 x"})
    expect_error<ConfigError>([&] { EffortControl(33, kLevels, wrong, 5); }, {"record", wrong});
}

TEST(Budget, OneThatCannotHoldLeavesPatchesOutAndTheRecordReproducesTheModel) {
  const std::vector<Capture> images = glossy_captures(40);
  const SurfaceLightFieldOptions options = plain_options();
  Reconstruction hurried(*square_object().mesh, options);
  hurried.keep_within({.image_ms = 1e-9});  // no machine holds it, so what happens does not hang on its speed
  for (const Capture& image : images) hurried.ingest(image);
  EXPECT_GT(hurried.effort().level, 0) << "coarser maps lose nothing of a scene as smooth as this";
  EXPECT_LT(hurried.effort().update_fraction, 0.2);
  EXPECT_GT(hurried.account().patches().left_out, hurried.account().patches().updated / 4);
  EXPECT_EQ(hurried.account().counts().accepted, images.size());
  EXPECT_EQ(hurried.account().counts().received, images.size());

  Reconstruction again(*square_object().mesh, options);
  again.keep_within({.image_ms = 1e9}, hurried.effort_record(), images.size());
  for (const Capture& image : images) again.ingest(image);
  expect_same_patches(*hurried.snapshot(), *again.snapshot());
}

TEST(Budget, OneThatHoldsChangesNothing) {
  const std::vector<Capture> images = glossy_captures(12);
  Reconstruction free(*square_object().mesh, plain_options()), within(*square_object().mesh, plain_options());
  within.keep_within({.image_ms = 1e9});
  for (const Capture& image : images) {
    free.ingest(image);
    within.ingest(image);
  }
  expect_same_patches(*free.snapshot(), *within.snapshot());
  EXPECT_EQ(within.effort(), Reconstruction::Effort{});
  EXPECT_EQ(within.account().patches().left_out, 0u);
}

TEST(Budget, ALevelIsTakenForWhatItLosesOnTheScene) {
  // Waves no longer than a few samples of the finest maps: no coarser ones hold them.
  const analytic::Scene fine{square_object().surface, analytic::two_terms(0.004)};
  const std::vector<Capture> images = captures(fine, analytic::eyes(12, 0.5, 0.55));
  Reconstruction hurried(*square_object().mesh, plain_options());
  hurried.keep_within({.image_ms = 1e-9});
  for (const Capture& image : images) hurried.ingest(image);
  EXPECT_EQ(hurried.effort().level, 0);
}

TEST(Budget, WhatWasMeasuredOnTheSceneDecides) {
  const std::vector<Capture> images = glossy_captures(10);
  MeasuredLevels measured(kLevels, {.image_ms = 10, .psnr_db = 30});
  for (std::size_t r = 2; r < measured.size(); ++r) measured[r].psnr_db = 29;
  Reconstruction hurried(*square_object().mesh, plain_options());
  hurried.keep_within({.image_ms = 1e-9}, {}, 0, measured);
  for (const Capture& image : images) hurried.ingest(image);
  EXPECT_EQ(hurried.effort().level, 1);

  Reconstruction wanted(*square_object().mesh, plain_options());
  wanted.keep_within({.psnr_db = 28.5}, {}, 0, measured);
  EXPECT_EQ(wanted.effort().level, static_cast<int>(measured.size()) - 1);
  wanted.keep_within({.psnr_db = 29.5}, {}, 0, measured);
  EXPECT_EQ(wanted.effort().level, 1);
}

TEST(Memory, TheBoundHoldsWhateverComes) {
  SurfaceLightFieldOptions options = plain_options();
  options.patch.factor.tolerance = 0;  // all the terms that there may be
  const std::vector<Capture> images = glossy_captures(90);
  const Object object = square_object();
  const Mesh& mesh = *object.mesh;
  const MemoryAccount bound = largest_account(mesh, images[0], options);
  Reconstruction all(mesh, options);
  for (const Capture& image : images) all.ingest(image);
  const MemoryAccount held = all.memory();
  EXPECT_LE(held.model, bound.model);
  EXPECT_GT(held.model, 0.2 * bound.model) << "a bound that says something";
  EXPECT_LE(held.snapshots, bound.snapshots);
  EXPECT_GT(held.snapshots, 0.2 * bound.snapshots);
  EXPECT_LE(held.total(), bound.total());
}

TEST(Memory, ThePatchesAreCutDownAfterAnyImageThatWouldExceedIt) {
  SurfaceLightFieldOptions options = plain_options();
  options.patch.factor = {.max_rank = 24, .tolerance = 0};
  const std::vector<Capture> images = glossy_captures(90);
  const Object object = square_object();
  Reconstruction free(*object.mesh, options), bounded(*object.mesh, options);
  for (const Capture& image : images) free.ingest(image);
  const MemoryAccount full = free.memory();
  const double asked = full.total() - 0.4 * (full.model + full.snapshots);
  bounded.keep_within({.bytes = asked});
  for (const Capture& image : images) {
    bounded.ingest(image);
    ASSERT_LE(bounded.memory().total(), asked) << bounded.account().counts().received;
  }
  EXPECT_LT(light_field_options(bounded.model().settings(), "the test").patch.factor.terms_kept(),
            options.patch.factor.terms_kept());
  EXPECT_GT(bounded.memory().model, 0.3 * full.model) << "no smaller than need be";
}

TEST(Memory, TheFinestMapsAreKeptWhereTheFewestTermsAndViewsFit) {
  SurfaceLightFieldOptions options = plain_options(), fewest = options;
  options.patch.factor = {.max_rank = 24, .tolerance = 0};
  const PatchLimit& last = memory_steps().back();
  fewest.patch = options.patch.limited_to(last);
  const std::vector<Capture> images = glossy_captures(90);
  const Object object = square_object();
  Reconstruction bounded(*object.mesh, options);
  const double asked = largest_account(*object.mesh, images[0], fewest).total();
  bounded.keep_within({.bytes = asked});
  for (const Capture& image : images) {
    bounded.ingest(image);
    ASSERT_LE(bounded.memory().total(), asked) << bounded.account().counts().received;
  }
  EXPECT_EQ(bounded.effort().level, 0);
  const std::shared_ptr<const ModelSnapshot> model = bounded.snapshot();
  Eigen::Index most = 0;
  for (const auto& patch : dynamic_cast<const SurfaceLightFieldSnapshot&>(*model).patches())
    for (const VertexInterpolant& vertex : patch->vertices) most = std::max(most, vertex.views->directions.cols());
  EXPECT_LT(most, static_cast<Eigen::Index>(images.size()) / 2) << "views were merged";
  EXPECT_GE(most, last.max_views);
}

TEST(Memory, WhatWasCutDownIsAFunctionOfTheCaptures) {
  SurfaceLightFieldOptions options = plain_options();
  options.patch.factor = {.max_rank = 24, .tolerance = 0};
  const std::vector<Capture> images = glossy_captures(60);
  Reconstruction free(*square_object().mesh, options), once(*square_object().mesh, options),
      watched(*square_object().mesh, options);
  for (const Capture& image : images) free.ingest(image);
  const MemoryAccount full = free.memory();
  for (Reconstruction* r : {&once, &watched})
    r->keep_within({.bytes = full.total() - 0.4 * (full.model + full.snapshots)});
  for (const Capture& image : images) once.ingest(image);
  for (int turn = 0; turn < 2; ++turn) {  // the second time as after an image was taken back
    watched.restart();
    for (const Capture& image : images) {
      watched.ingest(image);
      watched.snapshot();
    }
    expect_same_patches(*once.snapshot(), *watched.snapshot());
  }
  EXPECT_LT(light_field_options(once.model().settings(), "the test").patch.factor.terms_kept(),
            options.patch.factor.terms_kept());
}

}  // namespace
}  // namespace sheen
