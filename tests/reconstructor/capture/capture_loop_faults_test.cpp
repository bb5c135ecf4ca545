// SPDX-License-Identifier: Apache-2.0
// What must not stop a capture, or be told wrongly: damaged files, a locked database, clocks of two machines.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <atomic>
#include <new>
#include <stdexcept>
#include <thread>

#include "reconstructor/capture/capture_loop.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/link.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::eventually;
using testing::kLong;

constexpr std::size_t kImages = 8;
constexpr const char* kSource = "analytic";

class CaptureLoopFaults : public ::testing::Test {
 protected:
  CaptureLoopFaults() {
    images_ = captures({object_.surface, analytic::two_terms(0.1)}, analytic::eyes(kImages, 0.5, 0.55));
  }

  void start(Session session, const std::string& tracker = "tcp://127.0.0.1:9",
             LoopObserver observer = {.on_snapshot = [](auto, auto) {}}) {
    reconstruction_ = std::make_unique<Reconstruction>(*object_.mesh, plain_options());
    ReceiverOptions link = testing::receiver_options(tracker);
    link.held = session.held();
    loop_ =
        std::make_unique<CaptureLoop>(folder_, std::move(session), std::make_unique<TrackerLinks>(std::vector{link}),
                                      *reconstruction_, CaptureLoopOptions{}, std::move(observer));
    loop_->start();
  }
  bool ingests(std::uint64_t captures) {
    return eventually([&] { return loop_->status().ingested == captures || !loop_->status().error.empty(); }) &&
           loop_->status().error.empty();
  }

  const TempFolder temp_;
  const fs::path folder_ = temp_.path() / "session";
  const Object object_ = square_object();
  std::vector<Capture> images_;
  std::unique_ptr<Reconstruction> reconstruction_;
  std::unique_ptr<CaptureLoop> loop_;
};

TEST_F(CaptureLoopFaults, ADamagedFileIsCountedAndStopsNeitherThisCaptureNorTheNextStart) {
  {
    Session session = Session::create(folder_);
    for (const Capture& image : images_) session.append(image);
  }
  fs::resize_file(folder_ / "captures/00000002.capture", 1000);
  fs::remove(folder_ / "captures/00000005.capture");
  Reconstruction never(*object_.mesh, plain_options());
  for (std::size_t i = 0; i < kImages; ++i)
    if (i != 2 && i != 5) never.ingest(images_[i]);

  for (int round = 0; round < 2; ++round) {
    start(Session::open(folder_));
    ASSERT_TRUE(ingests(kImages)) << loop_->status().error;
    const FrameCounts counts = loop_->status().counts;
    EXPECT_EQ(counts.received, kImages);
    EXPECT_EQ(counts.accepted, kImages - 2);
    EXPECT_EQ(counts.refused, (std::map<std::string, std::uint64_t>{{"damaged file", 2}}));
    loop_->stop();
    EXPECT_EQ(loop_->status().error, "");
    expect_same_patches(*reconstruction_->snapshot(), *never.snapshot());
    loop_.reset();
  }
}

TEST_F(CaptureLoopFaults, TakingADamagedImageBackEndsInTheModelWithoutIt) {
  {
    Session session = Session::create(folder_);
    for (const Capture& image : images_) session.append(image);
  }
  fs::resize_file(folder_ / "captures/00000002.capture", 1000);
  start(Session::open(folder_));
  ASSERT_TRUE(ingests(kImages));
  Session::open_to_withdraw(folder_).set_withdrawn(2, true);
  ASSERT_TRUE(eventually([&] { return loop_->status().counts.withdrawn == 1 && loop_->status().exact; }))
      << loop_->status().error;
  EXPECT_TRUE(ingests(kImages));
  EXPECT_TRUE(loop_->status().counts.refused.empty());
}

TEST_F(CaptureLoopFaults, WhoWatchesMayFailAndTheCaptureGoesOn) {
  CaptureSender sender(testing::sender_options(testing::kAnyPort, kSource));
  std::atomic<int> snapshots = 0, shown = 0, captures = 0, links = 0;
  start(Session::create(folder_), sender.endpoint(),
        {.on_snapshot =
             [&](auto, auto) {
               if (++snapshots <= 2) throw std::bad_alloc();
               ++shown;
             },
         .on_capture =
             [&](const Capture&) {
               if (++captures % 2 == 1) throw std::runtime_error("the preview cannot be drawn");
               throw 7;
             },
         .on_link =
             [&](const std::vector<LinkState>&) {
               if (++links % 2 == 1) throw std::bad_alloc();
             }});
  for (const Capture& image : images_) ASSERT_TRUE(sender.keep(image, kLong));
  EXPECT_TRUE(ingests(kImages)) << loop_->status().error;
  EXPECT_TRUE(eventually([&] { return sender.stats().acknowledged == kImages && captures == int{kImages}; }));
  EXPECT_TRUE(eventually([&] { return shown > 0; })) << "a snapshot that was not shown is shown later";
  EXPECT_EQ(loop_->status().error, "");
  EXPECT_FALSE(loop_->finished());
  loop_.reset();  // before what it counts in
}

TEST_F(CaptureLoopFaults, OfTwoSourcesByOneNameOneIsRefusedAndTold) {
  CaptureSender one(testing::sender_options(testing::kAnyPort, kSource)),
      other(testing::sender_options(testing::kAnyPort, kSource));
  reconstruction_ = std::make_unique<Reconstruction>(*object_.mesh, plain_options());
  loop_ = std::make_unique<CaptureLoop>(
      folder_, Session::create(folder_),
      std::make_unique<TrackerLinks>(
          std::vector{testing::receiver_options(one.endpoint()), testing::receiver_options(other.endpoint())}),
      *reconstruction_, CaptureLoopOptions{}, LoopObserver{});
  loop_->start();
  std::vector<Capture> others = images_;
  for (Capture& image : others) image.image.bytes.at(0) ^= 1;
  for (std::size_t i = 0; i < kImages; ++i) {
    ASSERT_TRUE(one.keep(images_[i], kLong));
    ASSERT_TRUE(other.keep(others[i], kLong));
  }
  ASSERT_TRUE(ingests(kImages)) << loop_->status().error;
  const bool first = one.stats().acknowledged > 0;
  CaptureSender &stored = first ? one : other, &refused = first ? other : one;
  EXPECT_TRUE(eventually([&] { return stored.stats().acknowledged == kImages; }));
  EXPECT_TRUE(eventually([&] { return !refused.stats().last_refusal.empty(); }));
  EXPECT_THAT(refused.stats().last_refusal, ::testing::HasSubstr("another image"));
  EXPECT_FALSE(refused.finish(300ms));
  EXPECT_EQ(refused.stats().acknowledged, 0u);
  EXPECT_THAT(loop_->status().link().last_error, ::testing::HasSubstr("another image"));
  const Session session = Session::open_read_only(folder_);
  for (std::uint64_t i = 0; i < kImages; ++i)
    EXPECT_EQ(session.read(i).image, (first ? images_ : others)[i].image) << "never some of each";
  EXPECT_EQ(session.size(), kImages);
}

/// Keeps the database locked as a browser of databases does, until it goes.
class Locked {
 public:
  explicit Locked(const fs::path& session) {
    EXPECT_EQ(sqlite3_open((session / "session.sqlite").c_str(), &db_), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(db_, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  }
  ~Locked() { sqlite3_close(db_); }

 private:
  sqlite3* db_ = nullptr;
};

TEST_F(CaptureLoopFaults, ALockedDatabaseIsWaitedForWithoutAnAcknowledgement) {
  CaptureSender sender(testing::sender_options(testing::kAnyPort, kSource));
  start(Session::create(folder_), sender.endpoint());
  {
    const Locked locked(folder_);
    for (const Capture& image : images_) ASSERT_TRUE(sender.keep(image, kLong));
    std::this_thread::sleep_for(3s);  // longer than any one attempt lasts
    EXPECT_EQ(loop_->status().error, "");
    EXPECT_EQ(loop_->status().journaled, 0u);
    EXPECT_EQ(sender.stats().acknowledged, 0u);
  }
  EXPECT_TRUE(eventually([&] { return sender.stats().acknowledged == kImages; })) << loop_->status().error;
  EXPECT_TRUE(ingests(kImages));
}

TEST_F(CaptureLoopFaults, StoppingDoesNotWaitForALockedDatabase) {
  CaptureSender sender(testing::sender_options(testing::kAnyPort, kSource));
  start(Session::create(folder_), sender.endpoint());
  const Locked locked(folder_);
  ASSERT_TRUE(sender.keep(images_[0], kLong));
  ASSERT_TRUE(eventually([&] { return sender.stats().delivered == 1; }));
  std::this_thread::sleep_for(200ms);
  const auto begun = std::chrono::steady_clock::now();
  loop_->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - begun, 5s) << "a second, on a machine that is not busy";
  EXPECT_EQ(loop_->status().error, "");
  EXPECT_EQ(sender.stats().acknowledged, 0u);
}

class ClocksOfTwoMachines : public CaptureLoopFaults, public ::testing::WithParamInterface<std::int64_t> {};

TEST_P(ClocksOfTwoMachines, DoNotEnterTheLatency) {
  testing::RawPeer tracker(zmq::socket_type::router);
  tracker.socket.bind(testing::kAnyPort);
  start(Session::create(folder_), tracker.socket.get(zmq::sockopt::last_endpoint));
  const auto trackers_clock_ns = [&] {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count() + GetParam();
  };
  const Hello hello = decode_hello(tracker.receive(MessageType::kHello).at(1));
  tracker.say(MessageType::kWelcome, Welcome{kSource, 1, hello.clock_ns, trackers_clock_ns()});
  constexpr std::int64_t kAge_ns = 400'000'000;  // of an image when it is sent
  for (std::size_t i = 0; i < 2; ++i) {
    images_[i].times.grabbed_ns = trackers_clock_ns() - kAge_ns;
    tracker.say(encode_capture(images_[i], MessageType::kKeep, Codec::kRaw));
  }
  ASSERT_TRUE(eventually([&] { return loop_->status().latency.to_picture.count() == 2; })) << loop_->status().error;
  const double uncertainty_s = 1e-9 * static_cast<double>(loop_->status().links.at(0).stats.clock->round_trip_ns) / 2;
  const Latencies latency = loop_->status().latency;
  EXPECT_EQ(latency.to_disk.count(), 2u);
  EXPECT_EQ(latency.to_model.count(), 2u);
  EXPECT_GE(latency.to_disk.min_s(), 0.4 - uncertainty_s);
  EXPECT_GT(latency.to_model.min_s(), latency.to_disk.min_s());
  EXPECT_GT(latency.to_picture.min_s(), latency.to_model.min_s());
  EXPECT_LE(latency.to_picture.max_s(), 20) << "three days are far more";
}

constexpr std::int64_t kThreeDays_ns = std::int64_t{259'200} * 1'000'000'000;
INSTANTIATE_TEST_SUITE_P(Ahead, ClocksOfTwoMachines, ::testing::Values(kThreeDays_ns, -kThreeDays_ns, 0));

}  // namespace
}  // namespace sheen
