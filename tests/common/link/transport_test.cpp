// SPDX-License-Identifier: Apache-2.0
#include "common/link/transport.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <thread>

#include "common/base/errors.h"
#include "common/link/endpoint.h"
#include "tests/support/expect_same_bits.h"
#include "tests/support/link.h"
#include "tests/support/sample_capture.h"

namespace sheen {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using testing::eventually;
using testing::expect_kept;
using testing::expect_same_bits;
using testing::free_endpoint;
using ::testing::HasSubstr;
using testing::keep;
using testing::kLong;
using testing::receiver_options;
using testing::sample_capture;
using testing::sender_options;

/// A process of its own that can be killed at any moment. What runs in it must not touch the test's state.
class Process {
 public:
  explicit Process(const std::function<void()>& body) : pid_(::fork()) {
    if (pid_ == 0) {
      body();
      ::_exit(0);
    }
  }
  ~Process() { kill_and_wait(SIGKILL); }
  void kill_and_wait(int signal) {
    if (pid_ <= 0) return;
    ::kill(pid_, signal);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  void freeze() const { ::kill(pid_, SIGSTOP); }
  void thaw() const { ::kill(pid_, SIGCONT); }

 private:
  pid_t pid_;
};

TEST(Transport, TheReceiverLearnsWhatTheTrackerRefuses) {
  CaptureSender sender(sender_options());
  CaptureReceiver receiver(receiver_options(sender.endpoint()));
  sender.report({56, {{"motion_blur", 55}}, "too fast: motion blur"});
  EXPECT_TRUE(eventually([&] { return receiver.stats().tracker.judged == 56; }));
  EXPECT_EQ(receiver.stats().tracker.refused.at("motion_blur"), 55u);
  EXPECT_EQ(receiver.stats().tracker.trouble, "too fast: motion blur");
  // The last counts come before the end.
  sender.report({60, {{"motion_blur", 55}}, ""});
  EXPECT_TRUE(sender.finish(kLong));
  EXPECT_EQ(receiver.stats().tracker.judged, 60u);
  EXPECT_EQ(receiver.stats().tracker.trouble, "");
}

TEST(Transport, CapturesArriveInOrderUnharmedAndAreAcknowledged) {
  CaptureSender sender(sender_options());
  CaptureReceiver receiver(receiver_options(sender.endpoint()));
  std::jthread feeding([&] { keep(sender, 1, 200); });
  expect_kept(receiver, 1, 200);
  feeding.join();
  EXPECT_TRUE(sender.finish(kLong));
  EXPECT_TRUE(receiver.stats().ended);
  EXPECT_EQ(receiver.stats().kept, 200u);
  EXPECT_EQ(receiver.stats().duplicates, 0u);
  EXPECT_EQ(receiver.stats().rejected_messages, 0u);
  const SenderStats stats = sender.stats();
  EXPECT_EQ(stats.kept, 200u);
  EXPECT_EQ(stats.delivered, 200u);
  EXPECT_EQ(stats.acknowledged, 200u);
  EXPECT_EQ(stats.resent, 0u);
}

TEST(Transport, EveryFieldCrossesInBothCodecs) {
  for (const Codec codec : {Codec::kRaw, Codec::kDeltaZstd}) {
    SenderOptions options = sender_options();
    options.codec = codec;
    CaptureSender sender(options);
    CaptureReceiver receiver(receiver_options(sender.endpoint()));
    Capture sent = sample_capture(PixelFormat::kRGB8, 33, 21, 4, true, 3);
    sent.source_session = "s";
    ASSERT_TRUE(sender.keep(sent, kLong));
    const auto got = receiver.next(kLong);
    ASSERT_TRUE(got);
    EXPECT_GT(got->capture.times.sent_ns, 0);
    EXPECT_GE(got->capture.times.received_ns, got->capture.times.sent_ns);  // one machine, one steady clock
    sent.times.sent_ns = got->capture.times.sent_ns;
    expect_same_bits(sent, got->capture);
  }
}

TEST(Transport, TheReceiverMayStartFirst) {
  const std::string endpoint = free_endpoint();
  CaptureReceiver receiver(receiver_options(endpoint));
  EXPECT_FALSE(receiver.next(300ms));
  EXPECT_FALSE(receiver.stats().connected);
  CaptureSender sender(sender_options(endpoint));
  keep(sender, 1, 5);
  expect_kept(receiver, 1, 5);
  EXPECT_TRUE(receiver.stats().connected);
}

TEST(Transport, TheSenderMayStartLongBeforeTheReceiver) {
  CaptureSender sender(sender_options());
  keep(sender, 1, 10);
  CaptureReceiver receiver(receiver_options(sender.endpoint()));
  expect_kept(receiver, 1, 10);
}

TEST(Transport, SequencesAreFilledInAndMustFollowEachOther) {
  CaptureSender sender(sender_options());
  Capture capture = sample_capture("", 0);
  ASSERT_TRUE(sender.keep(capture, kLong));
  ASSERT_TRUE(sender.keep(capture, kLong));
  capture.sequence = 4;
  EXPECT_THROW(sender.keep(capture, kLong), ProtocolError);
  capture.source_session = "another";
  EXPECT_THROW(sender.live(capture), ProtocolError);
  CaptureReceiver receiver(receiver_options(sender.endpoint()));
  for (const std::uint64_t sequence : {1, 2}) {
    const auto got = receiver.next(kLong);
    ASSERT_TRUE(got);
    EXPECT_EQ(got->capture.sequence, sequence);
    EXPECT_EQ(got->capture.source_session, "s");
  }
}

TEST(Transport, AFullSenderWaitsAndTakesNothingOnTimeout) {
  SenderOptions options = sender_options();
  options.retained = 3;
  CaptureSender sender(options);
  keep(sender, 1, 3);
  EXPECT_FALSE(sender.keep(sample_capture("s", 4), 50ms));
  CaptureReceiver receiver(receiver_options(sender.endpoint()));
  expect_kept(receiver, 1, 3);
  keep(sender, 4, 4);
  expect_kept(receiver, 4, 4);
  EXPECT_TRUE(sender.finish(kLong));
}

TEST(Transport, FinishDoesNotClaimWhatWasNotAcknowledged) {
  CaptureSender sender(sender_options());
  CaptureReceiver receiver(receiver_options(sender.endpoint()));
  keep(sender, 1, 2);
  expect_kept(receiver, 1, 1, true);
  expect_kept(receiver, 2, 2, false);
  EXPECT_FALSE(sender.finish(200ms));
  EXPECT_THROW(sender.keep(sample_capture("s", 3), 0ms), Error);
  receiver.acknowledge("s", 2);
  EXPECT_TRUE(sender.finish(kLong));
}

TEST(Transport, TheLastAcknowledgementLeavesThoughTheReceiverIsGoneAtOnce) {
  for (int round = 0; round < 20; ++round) {
    CaptureSender sender(sender_options());
    {
      CaptureReceiver receiver(receiver_options(sender.endpoint()));
      keep(sender, 1, 1);
      expect_kept(receiver, 1, 1);
    }
    ASSERT_TRUE(eventually([&] { return sender.stats().acknowledged == 1; }));
  }
}

TEST(Transport, LiveIsLatestWinsAndCounted) {
  CaptureSender sender(sender_options());
  for (std::uint64_t i = 1; i <= 50; ++i) sender.live(sample_capture("s", i));  // nobody is there yet
  EXPECT_EQ(sender.stats().live_dropped, 49u);
  CaptureReceiver receiver(receiver_options(sender.endpoint()));
  const auto got = receiver.next(kLong);
  ASSERT_TRUE(got);
  EXPECT_TRUE(got->live);
  EXPECT_EQ(got->capture.sequence, 50u);
  EXPECT_FALSE(receiver.next(100ms));
  EXPECT_EQ(sender.stats().live_sent, 1u);
}

TEST(Transport, ASlowReceiverHoldsAtMostItsCreditsAndMissesNoKeyframe) {
  CaptureSender sender(sender_options());
  ReceiverOptions options = receiver_options(sender.endpoint());
  options.credits = 2;
  CaptureReceiver receiver(options);
  ASSERT_TRUE(eventually([&] { return sender.stats().peer_connected; }));
  keep(sender, 1, 20);
  for (std::uint64_t i = 1; i <= 300; ++i) sender.live(sample_capture("s", i));
  std::this_thread::sleep_for(200ms);
  EXPECT_EQ(sender.stats().delivered, 2u);
  EXPECT_EQ(sender.stats().live_sent, 0u);
  EXPECT_EQ(sender.stats().live_dropped, 299u);
  expect_kept(receiver, 1, 20);
  const auto live = receiver.next(kLong);
  ASSERT_TRUE(live);
  EXPECT_TRUE(live->live);
  EXPECT_EQ(live->capture.sequence, 300u);
}

TEST(Transport, AReceiverThatComesBackGoesOnWhereItsDiskEnds) {
  CaptureSender sender(sender_options());
  keep(sender, 1, 30);
  {
    CaptureReceiver receiver(receiver_options(sender.endpoint()));
    expect_kept(receiver, 1, 10, true);
    expect_kept(receiver, 11, 12, false);  // taken, but not yet on the disk when it dies
  }
  ReceiverOptions options = receiver_options(sender.endpoint());
  options.held = {{"s", 11}, {"an earlier run", 99}};  // 11 was written, its acknowledgement was not
  CaptureReceiver receiver(options);
  expect_kept(receiver, 12, 30);
  EXPECT_TRUE(sender.finish(kLong));
  EXPECT_EQ(receiver.stats().duplicates, 0u);
  EXPECT_EQ(receiver.stats().missing, 0u);
  EXPECT_GE(sender.stats().resent, 1u);
}

TEST(Transport, AKilledReceiverCostsNothing) {
  const std::string endpoint = free_endpoint();
  int pipe_ends[2];
  ASSERT_EQ(::pipe(pipe_ends), 0);
  Process process([&] {
    CaptureReceiver receiver(receiver_options(endpoint));
    for (int i = 0; i < 10; ++i)
      if (const auto got = receiver.next(kLong)) receiver.acknowledge("s", got->capture.sequence);
    [[maybe_unused]] const auto n = ::write(pipe_ends[1], "x", 1);
    ::pause();
  });
  CaptureSender sender(sender_options(endpoint));
  keep(sender, 1, 30);
  char ready;
  ASSERT_EQ(::read(pipe_ends[0], &ready, 1), 1);
  ASSERT_TRUE(eventually([&] { return sender.stats().acknowledged == 10; }));
  process.kill_and_wait(SIGKILL);
  ReceiverOptions options = receiver_options(endpoint);
  options.held = {{"s", 10}};
  CaptureReceiver receiver(options);
  expect_kept(receiver, 11, 30);
  EXPECT_TRUE(sender.finish(kLong));
}

TEST(Transport, AKilledSenderIsFollowedByItsNextRun) {
  const std::string endpoint = free_endpoint();
  auto first = std::make_unique<Process>([&] {
    CaptureSender sender(sender_options(endpoint, "run-1"));
    for (int i = 1; i <= 5; ++i) sender.keep(sample_capture("run-1", i), kLong);
    ::pause();
  });
  CaptureReceiver receiver(receiver_options(endpoint));
  expect_kept(receiver, 1, 5, true, "run-1");
  first->kill_and_wait(SIGKILL);
  ASSERT_TRUE(eventually([&] { return !receiver.stats().connected; }));
  CaptureSender sender(sender_options(endpoint, "run-2"));
  keep(sender, 1, 5, "run-2");
  expect_kept(receiver, 1, 5, true, "run-2");
  EXPECT_TRUE(sender.finish(kLong));
  EXPECT_TRUE(receiver.stats().ended);
  EXPECT_EQ(receiver.stats().missing, 0u);
}

TEST(Transport, ASourceThatRepeatsItselfSendsOnlyWhatIsNotHeld) {  // a data set streamed again under the same name
  SenderOptions repeated = sender_options();
  repeated.sent_before = 10;
  CaptureSender sender(repeated);
  ReceiverOptions options = receiver_options(sender.endpoint());
  options.held = {{"s", 7}};
  CaptureReceiver receiver(options);
  keep(sender, 1, 10);
  expect_kept(receiver, 8, 10);
  EXPECT_TRUE(sender.finish(kLong));
  EXPECT_EQ(sender.stats().acknowledged, 10u);
  EXPECT_LE(receiver.stats().duplicates, 7u);
}

TEST(Transport, AnotherReceiverIsToldWhatItMissed) {
  CaptureSender sender(sender_options());
  keep(sender, 1, 6);
  {
    CaptureReceiver first(receiver_options(sender.endpoint()));
    expect_kept(first, 1, 4);
    ASSERT_TRUE(eventually([&] { return sender.stats().acknowledged == 4; }));
  }
  CaptureReceiver second(receiver_options(sender.endpoint()));
  expect_kept(second, 5, 6);
  EXPECT_EQ(second.stats().missing, 4u);
  EXPECT_THAT(second.stats().last_error, HasSubstr("captures 1 to 4"));
}

TEST(Transport, ASecondReceiverIsRefusedAndTheFirstKeepsTheData) {
  CaptureSender sender(sender_options());
  auto first = std::make_unique<CaptureReceiver>(receiver_options(sender.endpoint()));
  ASSERT_TRUE(eventually([&] { return first->stats().connected; }));
  CaptureReceiver second(receiver_options(sender.endpoint()));
  ASSERT_TRUE(eventually([&] { return !second.stats().last_error.empty(); }));
  EXPECT_THAT(second.stats().last_error, HasSubstr("another receiver"));
  keep(sender, 1, 5);
  expect_kept(*first, 1, 5);
  EXPECT_FALSE(second.next(50ms));
  ASSERT_TRUE(eventually([&] { return sender.stats().acknowledged == 5; }));
  first.reset();
  keep(sender, 6, 8);  // and takes over when the first is gone
  expect_kept(second, 6, 8);
}

TEST(Transport, AFrozenReceiverIsReplacedOnceItsHeartbeatsAreMissed) {
  const std::string endpoint = free_endpoint();
  Process frozen([&] {
    CaptureReceiver receiver(receiver_options(endpoint));
    ::pause();
  });
  CaptureSender sender(sender_options(endpoint));
  ASSERT_TRUE(eventually([&] { return sender.stats().peer_connected; }));
  keep(sender, 1, 4);
  frozen.freeze();
  CaptureReceiver receiver(receiver_options(endpoint));
  expect_kept(receiver, 1, 4);
}

TEST(Transport, AReceiverThatIsBusyWithWhatCameIsNotTakenForFrozen) {
  constexpr int kCaptures = 7;
  CaptureSender sender(sender_options());
  keep(sender, 1, kCaptures);
  ReceiverOptions options = receiver_options(sender.endpoint());
  options.credits = kCaptures;
  options.on_arrival = [] {
    std::this_thread::sleep_for(std::chrono::milliseconds(900));
  };  // as if unpacking took so long
  CaptureReceiver receiver(options);
  expect_kept(receiver, 1, kCaptures);
  EXPECT_TRUE(sender.finish(kLong));
  EXPECT_EQ(sender.stats().last_refusal, "");
  EXPECT_EQ(sender.stats().resent, 0u);
}

TEST(Transport, AFrozenSenderIsNoticedAndLosesNothing) {  // to its peer this is a cut cable
  const std::string endpoint = free_endpoint();
  Process frozen([&] {
    CaptureSender sender(sender_options(endpoint));
    for (int i = 1; i <= 8; ++i) sender.keep(sample_capture("s", i), kLong);
    ::pause();
  });
  CaptureReceiver receiver(receiver_options(endpoint));
  expect_kept(receiver, 1, 3);
  frozen.freeze();
  ASSERT_TRUE(eventually([&] { return !receiver.stats().connected; }));
  frozen.thaw();
  expect_kept(receiver, 4, 8);
  EXPECT_EQ(receiver.stats().missing, 0u);
}

TEST(Transport, APortInUseIsAnErrorThatNamesIt) {
  CaptureSender first(sender_options());
  try {
    CaptureSender second(sender_options(first.endpoint()));
    FAIL() << "bound twice";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(first.endpoint()), HasSubstr("another program")));
  }
}

TEST(Transport, LocalhostIsLoopbackOnBothSides) {
  CaptureSender sender(sender_options("tcp://localhost:*"));
  std::string endpoint = sender.endpoint();
  EXPECT_TRUE(endpoint.starts_with("tcp://127.0.0.1:")) << endpoint;
  CaptureReceiver receiver(receiver_options("tcp://localhost" + endpoint.substr(endpoint.rfind(':'))));
  keep(sender, 1, 2);
  expect_kept(receiver, 1, 2);
}

TEST(Transport, MalformedEndpointsAreRefusedSayingHowToWriteThem) {
  for (const char* endpoint :
       {"", "nonsense", "localhost:7410", "tcp://", "tcp://127.0.0.1", "tcp://127.0.0.1:", "tcp://:7410",
        "tcp://127.0.0.1:65536", "tcp://127.0.0.1:70000", "tcp://127.0.0.1:-1", "tcp://127.0.0.1:7410x",
        "tcp://127.0.0.1: 7410", "tcp://::1:7410", "tcp://[::1]", "tcp://[]:7410", "udp://127.0.0.1:7410", "ipc://",
        "tcp://127.0.0.1:99999999999999999999"}) {
    EXPECT_THAT(endpoint_error(endpoint), AllOf(HasSubstr(endpoint), HasSubstr("tcp://HOST:PORT")));
    EXPECT_THROW(CaptureSender{sender_options(endpoint)}, ConfigError) << endpoint;
    EXPECT_THROW(CaptureReceiver{receiver_options(endpoint)}, ConfigError) << endpoint;
  }
  for (const char* endpoint : {"tcp://127.0.0.1:7410", "tcp://localhost:0", "tcp://*:65535", "tcp://[::1]:*",
                               "tcp://rig.example.org:7410", "ipc:///tmp/x", "inproc://x"})
    EXPECT_EQ(endpoint_error(endpoint), "") << endpoint;
  for (const char* endpoint : {"tcp://127.0.0.1:*", "tcp://localhost:0"})
    EXPECT_THROW(CaptureReceiver{receiver_options(endpoint)}, ConfigError) << "a port to connect to: " << endpoint;
}

TEST(Transport, BeyondLoopbackKeysAreRequired) {
  for (const char* endpoint : {"tcp://*:7410", "tcp://0.0.0.0:7410", "tcp://192.168.1.4:7410", "tcp://eth0:7410",
                               "tcp://[::]:7410", "tcp://127.example.org:7410"}) {
    EXPECT_THROW(CaptureSender{sender_options(endpoint)}, ConfigError) << endpoint;
    EXPECT_THROW(CaptureReceiver{receiver_options(endpoint)}, ConfigError) << endpoint;
  }
}

}  // namespace
}  // namespace sheen
