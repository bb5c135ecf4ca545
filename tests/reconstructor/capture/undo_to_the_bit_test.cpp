// SPDX-License-Identifier: Apache-2.0
// An image is taken back: the model is one that was made of the others, to the bit, at once or when it is rebuilt.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>

#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/effort/effort_control.h"
#include "reconstructor/models/surface_light_field/effort_levels.h"
#include "reconstructor/models/surface_light_field/memory_account.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;
using Withdrawn = Reconstruction::Withdrawn;

constexpr Limits kNeverKept{.image_ms = 1e-9};  // no machine holds it, so nothing hangs on its speed

class UndoToTheBit : public ::testing::Test {
 protected:
  UndoToTheBit() {
    options_.hold_out_every = 6;
    images_ = captures(scene_, eyes(24, 0.5, 0.55));
    images_[kRefused].pose.camera_from_object = look_at({0, 0, 0.5}, {0, 0, 1}, {0, 1, 0});
    images_[kRepeated].image = images_[3].image;
    images_[kRepeated].camera = images_[3].camera;
    images_[kRepeated].pose = images_[3].pose;
    // Of this place, half was hidden before.
    images_[kPartlySkipped] = images_[6];
    images_[kPartlySkipped].sequence = kPartlySkipped + 1;
    images_[6].mask = ImageU8(160, 120, 1, 255);
    for (int y = 0; y < 120; ++y) std::fill_n(images_[6].mask.row(y), 80, std::uint8_t{0});
  }
  static constexpr std::size_t kRefused = 1, kHeldOut = 11, kRepeated = 13, kPartlySkipped = 15;

  std::unique_ptr<Reconstruction> made_of(const Limits& limits = {}) {
    auto made = std::make_unique<Reconstruction>(*object_.mesh, options_);
    made->keep_within(limits);
    for (const Capture& image : images_) made->ingest(image);
    return made;
  }
  void replay(Reconstruction& into, const std::set<std::size_t>& without) const {
    for (std::size_t i = 0; i < images_.size(); ++i) {
      if (without.contains(i))
        into.leave_out(1);
      else
        into.ingest(images_[i]);
    }
  }
  /// `model` is one that was never given the images, and follows the same record.
  void expect_never_given(Reconstruction& model, const std::set<std::size_t>& missing) const {
    Reconstruction fresh(*object_.mesh, options_);
    fresh.keep_within(model.limits(), model.effort_record(), images_.size());
    replay(fresh, missing);
    expect_same_patches(*model.snapshot(), *fresh.snapshot());
    EXPECT_EQ(model.effort(), fresh.effort());
    EXPECT_EQ(model.judge().model.psnr_db, fresh.judge().model.psnr_db);
    EXPECT_EQ(model.judge().constant.psnr_db, fresh.judge().constant.psnr_db);
    const FrameCounts &a = model.account().counts(), &b = fresh.account().counts();
    EXPECT_EQ(a.received, b.received);
    EXPECT_EQ(a.accepted, b.accepted);
    EXPECT_EQ(a.held_out, b.held_out);
    EXPECT_EQ(a.refused, b.refused);
    EXPECT_EQ(a.withdrawn, b.withdrawn);
    EXPECT_EQ(model.account().captures().size(), fresh.account().captures().size());
    EXPECT_EQ(model.account().patches().updated, fresh.account().patches().updated);
    EXPECT_EQ(model.account().patches().skipped, fresh.account().patches().skipped);
    EXPECT_EQ(model.memory().total(), fresh.memory().total());
  }
  void expect_exact_after_a_restart(Reconstruction& model, const std::set<std::size_t>& missing) const {
    model.restart();
    replay(model, missing);
    expect_never_given(model, missing);
  }

  const Object object_ = square_object();
  const Scene scene_{object_.surface, analytic::two_terms(0.1), Eigen::Vector3d::Zero()};
  SurfaceLightFieldOptions options_;
  std::vector<Capture> images_;
};

TEST_F(UndoToTheBit, AtOnceWhereTheModelTookNothingOfTheImage) {
  const auto model = made_of();
  std::set<std::size_t> missing;
  for (const std::size_t image : {kRefused, kHeldOut, kRepeated}) {
    EXPECT_EQ(model->withdraw(images_[image]), Withdrawn::kExactly) << image;
    missing.insert(image);
    expect_never_given(*model, missing);
  }
  EXPECT_TRUE(model->account().counts().refused.empty());
  expect_exact_after_a_restart(*model, missing);
}

TEST_F(UndoToTheBit, AnImageThatSomePatchesSkippedIsTakenOutOfTheOthersFirst) {
  const auto model = made_of();
  const CaptureAccount::PatchCounts before = model->account().patches();
  ASSERT_GT(before.skipped, light_field(*model->snapshot()).mesh().vertices.size())
      << "the repetition and half of the other image";
  ASSERT_FALSE(model->account().captures()[kPartlySkipped].repeated);
  ASSERT_EQ(model->withdraw(images_[kPartlySkipped]), Withdrawn::kNearly);
  Reconstruction fresh(*object_.mesh, options_);
  replay(fresh, {kPartlySkipped});
  EXPECT_GT(model->judge().model.psnr_db, fresh.judge().model.psnr_db - 0.5);
  EXPECT_NEAR(model->judge().constant.psnr_db, fresh.judge().constant.psnr_db, 1e-3);
  expect_exact_after_a_restart(*model, {kPartlySkipped});
}

TEST_F(UndoToTheBit, ImagesOfABudgetThatLeavesPatchesOut) {
  for (const std::size_t image : {std::size_t{20}, std::size_t{4}, kRefused, kRepeated}) {
    const auto model = made_of(kNeverKept);
    ASSERT_LT(model->effort().update_fraction, 0.5);
    ASSERT_GT(model->account().patches().left_out, 0u);
    EXPECT_NE(model->withdraw(images_[image]), Withdrawn::kNot) << image;
    expect_exact_after_a_restart(*model, {image});
  }
}

TEST_F(UndoToTheBit, WhileTheEffortLevelOfABudgetIsStillToBeChosen) {
  Reconstruction model(*object_.mesh, options_);
  model.keep_within(kNeverKept);
  for (std::size_t i = 0; i < 6; ++i) model.ingest(images_[i]);
  ASSERT_TRUE(model.effort_record().empty());
  EXPECT_EQ(model.withdraw(images_[kRefused]), Withdrawn::kExactly);
  EXPECT_EQ(model.withdraw(images_[3]), Withdrawn::kNearly);
  for (std::size_t i = 6; i < images_.size(); ++i) model.ingest(images_[i]);
  ASSERT_FALSE(model.effort_record().empty());
  expect_exact_after_a_restart(model, {kRefused, 3});
}

TEST_F(UndoToTheBit, TheFirstImageTakesItsEffortLevelWithIt) {
  // It is seen in twice the detail, whose maps the memory cannot hold; those of the others it can.
  const Camera near{.width = 320, .height = 240, .fx = 500, .fy = 500, .cx = 159.5, .cy = 119.5};
  images_[0] = analytic::capture(scene_, near, images_[0].pose.camera_from_object);
  images_[0].sequence = 1;
  options_.patch = options_.patch.limited_to(memory_steps().back());  // that the memory must hold
  const auto bound = [&](const Capture& first) {
    return largest_account(*object_.mesh, first, options_).total() - MemoryAccount::kProgram;
  };
  Limits limits{.bytes = MemoryAccount::kProgram + 1.1 * bound(images_[2])};
  ASSERT_GT(bound(images_[0]), 1.1 * 1.1 * bound(images_[2]));
  for (const bool with_budget : {false, true}) {
    if (with_budget) limits.image_ms = 1e9;
    const auto model = made_of(limits);
    ASSERT_GT(model->effort().level, 0);
    EXPECT_EQ(model->withdraw(images_[0]), Withdrawn::kNot);
    expect_exact_after_a_restart(*model, {0});
    EXPECT_EQ(model->effort().level, 0);
  }
}

TEST_F(UndoToTheBit, WhatTheBudgetIsChosenByIsAcceptedAndFew) {
  Reconstruction model(*object_.mesh, options_);
  model.keep_within({.image_ms = 1e9});
  for (int i = 0; i < 40; ++i) model.ingest(images_[kRefused]);
  EXPECT_EQ(model.memory().probe, 0);
  for (std::size_t i = 0; i < 6; ++i) model.ingest(images_[i]);  // one is refused, one held out
  EXPECT_EQ(model.memory().probe, 4.0 * static_cast<double>(images_[0].image.bytes.size()));
  for (const Capture& image : images_) model.ingest(image);
  EXPECT_EQ(model.memory().probe, 0);
}

}  // namespace
}  // namespace sheen
