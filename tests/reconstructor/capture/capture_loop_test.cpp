// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/capture_loop.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "reconstructor/capture/capture_report.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/patience.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::size_t kImages = 14, kRefused = 12, kRepeated = 13;

/// 127.0.0.1 without a tracker.
std::unique_ptr<TrackerLinks> nobody() {
  ReceiverOptions link;
  link.endpoint = "tcp://127.0.0.1:9";
  return std::make_unique<TrackerLinks>(std::vector{link});
}

/// A loop over a session that nobody adds to; images 3, 7 and 11 are held out.
class CaptureLoopTest : public ::testing::Test {
 protected:
  CaptureLoopTest() {
    options_.hold_out_every = 4;
    images_ = captures({object_.surface, analytic::two_terms(0.1)}, analytic::eyes(kImages, 0.5, 0.55));
    images_[kRefused].pose.status = PoseStatus::kNoTags;
    images_[kRepeated] = images_[4];
    images_[kRepeated].sequence = kRepeated + 1;
    Session session = Session::create(folder_);
    for (const Capture& image : images_) session.append(image);
    reconstruction_ = std::make_unique<Reconstruction>(*object_.mesh, options_);
    loop_ = std::make_unique<CaptureLoop>(
        folder_, std::move(session), nobody(), *reconstruction_,
        CaptureLoopOptions{
            .snapshot_interval = milliseconds(0), .judge_interval = milliseconds(10), .pause = milliseconds(300)},
        LoopObserver{.on_snapshot = [this](auto snapshot, auto) { images_shown_.push_back(most_views(*snapshot)); }});
    loop_->start();
    wait_until([](const LoopStatus& s) { return s.ingested == kImages; });
  }

  static int most_views(const ModelSnapshot& snapshot) {
    int most = 0;
    for (const auto& patch : light_field(snapshot).patches())
      if (patch) most = std::max(most, patch->vertices.front().views_folded);
    return most;
  }
  template <typename Condition>
  void wait_until(const Condition& condition) {
    const auto deadline = std::chrono::steady_clock::now() + seconds(30 * testing::kPatienceFactor);
    while (!condition(loop_->status())) {
      ASSERT_LT(std::chrono::steady_clock::now(), deadline) << loop_->status().error;
      std::this_thread::sleep_for(milliseconds(5));
    }
  }
  void expect_model_without(const std::set<std::size_t>& missing) {
    loop_->stop();
    Reconstruction never(*object_.mesh, options_);
    for (std::size_t i = 0; i < kImages; ++i)
      if (!missing.contains(i)) never.ingest(images_[i]);
    expect_same_patches(*reconstruction_->snapshot(), *never.snapshot());
    ASSERT_EQ(reconstruction_->held_out().size(), never.held_out().size());
    EXPECT_EQ(reconstruction_->judge().model.psnr_db, never.judge().model.psnr_db);
    EXPECT_EQ(reconstruction_->judge().constant.psnr_db, never.judge().constant.psnr_db);
    const FrameCounts& counts = reconstruction_->account().counts();
    EXPECT_EQ(counts.received, kImages);
    EXPECT_EQ(counts.withdrawn, missing.size());
    EXPECT_EQ(counts.accepted, never.account().counts().accepted);
    EXPECT_EQ(counts.held_out, never.account().counts().held_out);
  }

  std::shared_ptr<const Mesh> another_mesh() const {
    Mesh mesh = *object_.mesh;
    for (Eigen::Vector3f& v : mesh.vertices) v.z() += 0.002f;
    return std::make_shared<const Mesh>(std::move(mesh));
  }
  void expect_model_on(const Mesh& mesh) {
    loop_->stop();
    Reconstruction built(mesh, options_);
    for (const Capture& image : images_) built.ingest(image);
    expect_same_patches(*reconstruction_->snapshot(), *built.snapshot());
    EXPECT_EQ(reconstruction_->judge().model.psnr_db, built.judge().model.psnr_db);
    EXPECT_EQ(reconstruction_->account().counts().accepted, built.account().counts().accepted);
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

TEST_F(CaptureLoopTest, GoesOverToAnotherMeshWhileTheWholeModelIsShown) {
  const auto mesh = another_mesh();
  loop_->go_over_to(mesh);
  loop_->finish();
  wait_until([this](const LoopStatus&) { return loop_->finished(); });
  EXPECT_TRUE(loop_->status().exact);
  EXPECT_FALSE(loop_->status().on_another_mesh);
  expect_model_on(*mesh);
  EXPECT_EQ(reconstruction_->snapshot()->shared_mesh(), mesh);
  const auto whole = std::max_element(images_shown_.begin(), images_shown_.end());
  for (auto shown = whole; shown != images_shown_.end(); ++shown) EXPECT_EQ(*shown, *whole);
}

TEST_F(CaptureLoopTest, WhereAMeshIsStillToComeItIsNotFinished) {
  loop_.reset();  // it holds the session
  reconstruction_ = std::make_unique<Reconstruction>(*object_.mesh, options_);
  loop_ = std::make_unique<CaptureLoop>(folder_, Session::open(folder_), nobody(), *reconstruction_,
                                        CaptureLoopOptions{.awaits_last_mesh = true}, LoopObserver{});
  loop_->start();
  loop_->finish();
  wait_until([](const LoopStatus& s) { return s.no_more_captures; });
  EXPECT_FALSE(loop_->finished());
  const auto mesh = another_mesh();
  loop_->go_over_to(mesh);
  loop_->no_other_mesh_follows();
  wait_until([this](const LoopStatus&) { return loop_->finished(); });
  expect_model_on(*mesh);
}

TEST_F(CaptureLoopTest, WhatAnotherProgramWithdrawsIsForgottenToTheBit) {
  Session desk = Session::open_to_withdraw(folder_);
  desk.set_withdrawn(0, true);  // the first one decides about maps and exposures
  wait_until([](const LoopStatus& s) { return s.exact && s.counts.withdrawn == 1; });
  desk.set_withdrawn(7, true);  // held out
  wait_until([](const LoopStatus& s) { return s.exact && s.counts.withdrawn == 2; });
  expect_model_without({0, 7});
}

TEST_F(CaptureLoopTest, TheLastOnesAreTakenBackOneByOneWhileTheWholeModelIsShown) {
  for (std::size_t last = kImages; last > kImages - 4; --last) EXPECT_EQ(loop_->withdraw_last(), last - 1);
  wait_until([](const LoopStatus& s) { return s.exact && s.counts.withdrawn == 4; });
  expect_model_without({kImages - 1, kImages - 2, kImages - 3, kImages - 4});
  // Up to the whole model, then to the one without: never back to a few images in between.
  const auto whole = std::max_element(images_shown_.begin(), images_shown_.end());
  for (auto shown = whole; shown != images_shown_.end(); ++shown) EXPECT_GE(*shown, *whole - 1);
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
  EXPECT_EQ(shown.back(), whole - 1) << "rebuilt";
}

TEST_F(CaptureLoopTest, WhatTheModelTookNothingOfIsTakenBackWithoutMakingItAnew) {
  Session desk = Session::open_to_withdraw(folder_);
  for (const std::size_t image : {kRefused, kRepeated}) {
    desk.set_withdrawn(image, true);
    LoopStatus then;
    wait_until([&](const LoopStatus& s) { return (then = s).counts.withdrawn > (image == kRefused ? 0u : 1u); });
    EXPECT_TRUE(then.exact) << image;
    EXPECT_EQ(then.rebuild_until, 0u) << image;
    EXPECT_EQ(then.ingested, kImages) << image;
  }
  expect_model_without({kRefused, kRepeated});
}

TEST_F(CaptureLoopTest, AnIdleLoopJudgesNoMore) {
  const auto judged = [](const LoopStatus& s) {
    return !s.held_out_curve.empty() && s.held_out_curve.back().images == s.counts.accepted;
  };
  wait_until(judged);
  const std::size_t points = loop_->status().held_out_curve.size();
  std::this_thread::sleep_for(milliseconds(500));  // fifty judgements, were they made
  EXPECT_EQ(loop_->status().held_out_curve.size(), points);
  EXPECT_GT(loop_->status().model_bytes, 0u);
  EXPECT_GT(loop_->status().trade.image_ms, 0);
  EXPECT_GT(loop_->status().trade.resident_bytes, 0);
  EXPECT_GE(loop_->status().trade.health.energy_lost, 0) << "looked at with each judgement";
  Session::open_to_withdraw(folder_).set_withdrawn(5, true);
  wait_until([&](const LoopStatus& s) { return s.exact && s.counts.withdrawn == 1 && judged(s); });
}

TEST_F(CaptureLoopTest, WhatIsPutBackIsThereAgain) {
  Session desk = Session::open_to_withdraw(folder_);
  desk.set_withdrawn(5, true);
  wait_until([](const LoopStatus& s) { return s.exact && s.counts.withdrawn == 1; });
  desk.set_withdrawn(5, false);
  wait_until([](const LoopStatus& s) { return s.exact && s.counts.withdrawn == 0; });
  expect_model_without({});
}

bool finishes(const CaptureLoop& loop) {
  for (const auto end = std::chrono::steady_clock::now() + seconds(30 * testing::kPatienceFactor);
       std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(std::chrono::milliseconds(5)))
    if (loop.finished()) return true;
  return false;
}

TEST(CaptureLoopEnds, WhatIsJournaledIsFoldedInAndWhatWasTakenBackIsOut) {
  const TempFolder temp;
  const Object object = square_object();
  const auto images = captures({object.surface, analytic::two_terms(0.1)}, analytic::eyes(kImages, 0.5, 0.55));
  Session session = Session::create(temp.path() / "session");
  for (const Capture& image : images) session.append(image);
  session.set_withdrawn(5, true);
  SurfaceLightFieldOptions options;
  options.hold_out_every = 4;
  Reconstruction reconstruction(*object.mesh, options), never(*object.mesh, options);
  CaptureLoop loop(temp.path() / "session", std::move(session), nobody(), reconstruction,
                   {.pause = std::chrono::hours(1)}, {});
  loop.start();
  while (loop.status().ingested < 8) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  Session::open_to_withdraw(temp.path() / "session").set_withdrawn(6, true);  // of what is in the model
  loop.finish();
  ASSERT_TRUE(finishes(loop));
  loop.stop();
  const LoopStatus status = loop.status();
  EXPECT_EQ(status.error, "");
  EXPECT_TRUE(status.exact);
  EXPECT_EQ(status.waiting(), 0u);
  EXPECT_EQ(status.counts.withdrawn, 2u);
  for (std::size_t i = 0; i < images.size(); ++i)
    if (i != 5 && i != 6) never.ingest(images[i]);
  expect_same_patches(*reconstruction.snapshot(), *never.snapshot());
}

TEST(CaptureLoopEnds, TheAccountAddsUpWhileImagesWait) {
  const TempFolder temp;
  const Object object = square_object();
  Session session = Session::create(temp.path() / "session");
  for (const Capture& image : captures({object.surface, analytic::two_terms(0.1)}, analytic::eyes(kImages, 0.5, 0.55)))
    session.append(image);
  Reconstruction reconstruction(*object.mesh, SurfaceLightFieldOptions{});
  CaptureLoop loop(temp.path() / "session", std::move(session), nobody(), reconstruction, {}, {});
  EXPECT_EQ(loop.status().waiting(), kImages) << "before the start";
  loop.start();
  while (loop.status().ingested < 2) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  loop.stop();
  const LoopStatus status = loop.status();
  EXPECT_EQ(status.journaled, kImages);
  EXPECT_EQ(status.counts.accepted + status.counts.held_out + status.waiting(), kImages);
  const nlohmann::json frames = live_report(reconstruction, reconstruction.judge(), status)["frames"];
  EXPECT_EQ(frames["received"], kImages);
  EXPECT_EQ(frames["waiting"], status.waiting());
  EXPECT_EQ(frames["lost"], 0) << "what is journaled is kept";
}

// Meant for the thread sanitizer: the ingesting thread fails at once, while `start` may still assign the others.
TEST(CaptureLoopEnds, ALoopThatFailsAtItsStartSaysSo) {
  const Object object = square_object();
  for (int i = 0; i < 20; ++i) {
    const TempFolder temp;
    Session session = Session::create(temp.path() / "session");
    Reconstruction reconstruction(*object.mesh, SurfaceLightFieldOptions{});
    CaptureLoop loop(temp.path() / "elsewhere", std::move(session), nobody(), reconstruction, {}, {});
    loop.start();
    ASSERT_TRUE(finishes(loop));
    EXPECT_NE(loop.status().error, "");
  }
}

}  // namespace
}  // namespace sheen
