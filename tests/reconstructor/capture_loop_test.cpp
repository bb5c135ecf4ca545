// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture_loop.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using std::chrono::seconds;

constexpr std::size_t kImages = 12;

/// A loop over a session that nobody adds to; images 3 and 7 are held out.
class CaptureLoopTest : public ::testing::Test {
 protected:
  CaptureLoopTest() {
    options_.hold_out_every = 4;
    images_ = captures({object_.surface, analytic::two_terms(0.1)}, analytic::eyes(kImages, 0.5, 0.55));
    Session session = Session::create(folder_);
    for (const Capture& image : images_) session.append(image);
    reconstruction_ = std::make_unique<Reconstruction>(*object_.mesh, options_);
    ReceiverOptions nobody;
    nobody.endpoint = "tcp://127.0.0.1:9";
    loop_ = std::make_unique<CaptureLoop>(
        folder_, std::move(session), nobody, *reconstruction_,
        CaptureLoopOptions{.snapshot_interval = std::chrono::milliseconds(0), .pause = std::chrono::milliseconds(300)},
        LoopObserver{.on_snapshot = [this](auto snapshot) { images_shown_.push_back(most_views(*snapshot)); }});
    loop_->start();
    wait_until([](const LoopStatus& s) { return s.ingested == kImages; });
  }

  static int most_views(const SurfaceLightFieldSnapshot& snapshot) {
    int most = 0;
    for (const auto& ring : snapshot.ring_data())
      if (ring) most = std::max(most, ring->views_folded);
    return most;
  }
  template <typename Condition>
  void wait_until(const Condition& condition) {
    const auto deadline = std::chrono::steady_clock::now() + seconds(30);
    while (!condition(loop_->status())) {
      ASSERT_LT(std::chrono::steady_clock::now(), deadline) << loop_->status().error;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  void expect_model_without(const std::set<std::size_t>& missing) {
    loop_->stop();
    Reconstruction never(*object_.mesh, options_);
    for (std::size_t i = 0; i < kImages; ++i)
      if (!missing.contains(i)) never.ingest(images_[i]);
    expect_same_rings(*reconstruction_->snapshot(), *never.snapshot());
    ASSERT_EQ(reconstruction_->held_out().size(), never.held_out().size());
    EXPECT_EQ(reconstruction_->judge().light_field.psnr_db, never.judge().light_field.psnr_db);
    EXPECT_EQ(reconstruction_->judge().constant.psnr_db, never.judge().constant.psnr_db);
    const FrameCounts& counts = reconstruction_->counts();
    EXPECT_EQ(counts.received, kImages);
    EXPECT_EQ(counts.withdrawn, missing.size());
    EXPECT_EQ(counts.accepted, never.counts().accepted);
    EXPECT_EQ(counts.held_out, never.counts().held_out);
  }

  const TempFolder temp_;
  const std::filesystem::path folder_ = temp_.path() / "session";
  const Object object_ = square_object();
  SurfaceLightFieldOptions options_;
  std::vector<Capture> images_;
  std::vector<int> images_shown_;  ///< a snapshot: how many images it is made of
  std::unique_ptr<Reconstruction> reconstruction_;
  std::unique_ptr<CaptureLoop> loop_;
};

TEST_F(CaptureLoopTest, WhatAnotherProgramWithdrawsIsForgottenToTheBit) {
  Session desk = Session::open_to_withdraw(folder_);
  desk.set_withdrawn(0, true);  // the first one decides about maps and exposures
  wait_until([](const LoopStatus& s) { return s.exact && s.counts.withdrawn == 1; });
  desk.set_withdrawn(7, true);  // held out
  wait_until([](const LoopStatus& s) { return s.exact && s.counts.withdrawn == 2; });
  expect_model_without({0, 7});
}

TEST_F(CaptureLoopTest, TheLastOnesAreTakenBackOneByOneWhileTheWholeModelIsShown) {
  EXPECT_EQ(loop_->withdraw_last(), kImages - 1);
  EXPECT_EQ(loop_->withdraw_last(), kImages - 2);
  wait_until([](const LoopStatus& s) { return s.exact && s.counts.withdrawn == 2; });
  expect_model_without({kImages - 1, kImages - 2});
  // Up to the whole model, then to the one without: never back to a few images in between.
  const auto whole = std::max_element(images_shown_.begin(), images_shown_.end());
  for (auto shown = whole; shown != images_shown_.end(); ++shown) EXPECT_GE(*shown, *whole - 2);
}

TEST_F(CaptureLoopTest, WhatIsTakenBackIsGoneFromThePictureBeforeTheModelIsMadeAnew) {
  Session::open_to_withdraw(folder_).set_withdrawn(5, true);
  wait_until([](const LoopStatus& s) { return s.counts.withdrawn == 1; });
  EXPECT_FALSE(loop_->status().exact);
  wait_until([](const LoopStatus& s) { return s.exact; });
  loop_->stop();
  const std::vector<int>& shown = images_shown_;
  ASSERT_GE(shown.size(), 3u);
  const int whole = shown[shown.size() - 3];
  EXPECT_EQ(whole, *std::max_element(shown.begin(), shown.end()));
  EXPECT_EQ(shown[shown.size() - 2], whole - 1) << "taken out";
  EXPECT_EQ(shown.back(), whole - 1) << "made anew";
}

TEST_F(CaptureLoopTest, WhatIsPutBackIsThereAgain) {
  Session desk = Session::open_to_withdraw(folder_);
  desk.set_withdrawn(5, true);
  wait_until([](const LoopStatus& s) { return s.exact && s.counts.withdrawn == 1; });
  desk.set_withdrawn(5, false);
  wait_until([](const LoopStatus& s) { return s.exact && s.counts.withdrawn == 0; });
  expect_model_without({});
}

}  // namespace
}  // namespace sheen
