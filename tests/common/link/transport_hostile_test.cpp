// SPDX-License-Identifier: Apache-2.0
// Baselines that do not keep to the protocol, or to this version of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "common/base/errors.h"
#include "common/link/transport.h"
#include "tests/support/link.h"

namespace sheen {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using testing::eventually;
using testing::expect_kept;
using ::testing::HasSubstr;
using testing::keep;
using testing::kLong;
using testing::RawPeer;
using testing::receiver_options;
using testing::sample_capture;
using testing::sender_options;

EncodedCapture kept(std::uint64_t sequence) {
  return encode_capture(sample_capture("s", sequence), MessageType::kKeep, Codec::kRaw);
}

/// A sender played by the test, with one real receiver that has said hello.
struct FakeSender : RawPeer {
  static constexpr int kCredits = 16;
  FakeSender() : RawPeer(zmq::socket_type::router) {
    socket.bind(testing::kAnyPort);
    ReceiverOptions options = receiver_options(socket.get(zmq::sockopt::last_endpoint));
    options.credits = kCredits;
    receiver.emplace(options);
  }
  Hello hear_hello() { return decode_hello(receive(MessageType::kHello).at(1)); }
  Hello welcome(std::uint64_t first_sequence = 1, const std::string& session = "s") {
    const Hello hello = hear_hello();
    say(MessageType::kWelcome, Welcome{session, first_sequence, hello.clock_ns, hello.clock_ns + kAhead_ns});
    return hello;
  }
  static constexpr std::int64_t kAhead_ns = 1'000'000'000;  ///< of this side's clock
  std::optional<CaptureReceiver> receiver;
};

/// A receiver played by the test, connected to a real sender.
struct FakeReceiver : RawPeer {
  explicit FakeReceiver(const SenderOptions& options = sender_options())
      : RawPeer(zmq::socket_type::dealer), sender(options) {
    socket.connect(sender.endpoint());
  }
  std::string hear_refusal() { return decode_refuse(receive(MessageType::kRefuse).at(1)).reason; }
  CaptureSender sender;
};

TEST(HostileSender, AGapIsNotAcceptedButAskedForAgain) {
  FakeSender peer;
  EXPECT_EQ(peer.welcome().held.count("s"), 0u);
  peer.say(kept(1));
  expect_kept(*peer.receiver, 1, 1);
  peer.say(kept(3));  // 2 is lost
  const Hello again = peer.welcome();
  EXPECT_EQ(again.held.at("s").received, 1u);
  for (const std::uint64_t sequence : {2, 3}) peer.say(kept(sequence));
  expect_kept(*peer.receiver, 2, 3);
  EXPECT_EQ(peer.receiver->stats().rejected_by_reason.at("gap"), 1u);
  EXPECT_EQ(peer.receiver->stats().missing, 0u);
}

TEST(HostileSender, AnAnswerMayTakeLongerThanAHelloIsRepeatedAfter) {
  FakeSender peer;
  for (int hello = 0; hello < 2; ++hello) {
    const Hello heard = peer.hear_hello();
    std::this_thread::sleep_for(700ms);  // behind large images on a slow link
    peer.say(MessageType::kWelcome, Welcome{"s", 1, heard.clock_ns, heard.clock_ns + FakeSender::kAhead_ns});
  }
  EXPECT_TRUE(eventually([&] { return peer.receiver->stats().connected; }));
}

TEST(HostileSender, DuplicatesAreDroppedAndCounted) {
  FakeSender peer;
  peer.welcome();
  for (const std::uint64_t sequence : {1, 1, 2, 1, 2, 3}) peer.say(kept(sequence));
  expect_kept(*peer.receiver, 1, 3);
  EXPECT_FALSE(peer.receiver->next(20ms));
  EXPECT_EQ(peer.receiver->stats().duplicates, 3u);
  EXPECT_EQ(peer.receiver->stats().kept, 3u);
}

TEST(HostileSender, ADamagedKeyframeIsAskedForAgain) {
  FakeSender peer;
  peer.welcome();
  EncodedCapture damaged = kept(1);
  damaged.blob[5] ^= 1;
  peer.say(damaged);
  EXPECT_EQ(peer.welcome().held["s"].received, 0u);
  peer.say(kept(1));
  expect_kept(*peer.receiver, 1, 1);
  EXPECT_EQ(peer.receiver->stats().rejected_by_reason.at("blob.crc32c"), 1u);
}

TEST(HostileSender, AnEndBeforeItsTimeSaysWhy) {
  FakeSender peer;
  peer.welcome();
  peer.say(MessageType::kEnd, End{"s", 0, "images/7.png: damaged PNG"});
  EXPECT_TRUE(eventually([&] { return peer.receiver->stats().ended; }));
  EXPECT_EQ(peer.receiver->stats().source_failure, "images/7.png: damaged PNG");
}

TEST(HostileSender, AnEndBeforeTheLastCaptureAsksForTheRest) {
  FakeSender peer;
  peer.welcome();
  peer.say(kept(1));
  peer.say(MessageType::kEnd, End{"s", 2});
  EXPECT_EQ(peer.welcome().held["s"].received, 1u);
  EXPECT_FALSE(peer.receiver->stats().ended);
  peer.say(kept(2));
  peer.say(MessageType::kEnd, End{"s", 2});
  expect_kept(*peer.receiver, 1, 2);
  EXPECT_TRUE(eventually([&] { return peer.receiver->stats().ended; }));
}

TEST(HostileSender, AnotherVersionIsRefusedNamingBoth) {
  FakeSender peer;
  const Hello hello = peer.hear_hello();
  peer.say(MessageType::kWelcome, Welcome{"s", 1, hello.clock_ns, 0}, 2);
  ASSERT_TRUE(eventually([&] { return !peer.receiver->stats().last_error.empty(); }));
  EXPECT_THAT(peer.receiver->stats().last_error, AllOf(HasSubstr("version 2"), HasSubstr("version 1")));
  EXPECT_FALSE(peer.receiver->stats().connected);
  EXPECT_EQ(peer.receiver->stats().rejected_by_reason.at("envelope.major"), 1u);
  peer.welcome();  // it keeps asking: the sender may be replaced by one that fits
  EXPECT_TRUE(eventually([&] { return peer.receiver->stats().connected; }));
}

TEST(HostileSender, TheClocksAreComparedAgainAndAgainAndTheShortestRoundTripCounts) {
  FakeSender peer;
  peer.welcome();
  ASSERT_TRUE(eventually([&] { return peer.receiver->stats().clock.has_value(); }));
  const ClockOffset first = *peer.receiver->stats().clock;
  EXPECT_GT(first.round_trip_ns, 0);
  EXPECT_NEAR(static_cast<double>(first.offset_ns), 1e9, static_cast<double>(first.round_trip_ns));

  Credit question = decode_credit(peer.receive(MessageType::kCredit).at(1));
  ASSERT_NE(question.clock_ns, 0);
  EXPECT_EQ(question.captures, 0u);
  std::this_thread::sleep_for(200ms);  // an answer that was held up says nothing new
  peer.say(MessageType::kWelcome, Welcome{"s", 1, question.clock_ns, question.clock_ns + 5 * FakeSender::kAhead_ns});
  question = decode_credit(peer.receive(MessageType::kCredit).at(1));
  EXPECT_EQ(peer.receiver->stats().clock->offset_ns, first.offset_ns);
  EXPECT_EQ(peer.receiver->stats().clock->round_trip_ns, first.round_trip_ns);
  peer.say(MessageType::kWelcome, Welcome{"s", 1, question.clock_ns + 1, 0});  // the answer to no question
  decode_credit(peer.receive(MessageType::kCredit).at(1));
  EXPECT_EQ(peer.receiver->stats().clock->offset_ns, first.offset_ns);
}

TEST(HostileSender, WhatExceedsTheCreditsIsDroppedUnopenedAndTheLinkGoesOn) {
  FakeSender peer;
  peer.welcome();
  constexpr std::uint64_t kSent = 400;
  for (std::uint64_t sequence = 1; sequence <= kSent; ++sequence) peer.say(kept(sequence));
  ASSERT_TRUE(eventually([&] {
    const ReceiverStats stats = peer.receiver->stats();
    return stats.kept + stats.rejected_messages >= kSent;
  }));
  const ReceiverStats stats = peer.receiver->stats();
  EXPECT_EQ(stats.kept, static_cast<std::uint64_t>(FakeSender::kCredits));
  EXPECT_EQ(stats.rejected_by_reason.at("credits"), kSent - stats.kept);
  const EncodedCapture one = kept(1);
  EXPECT_LE(stats.bytes, FakeSender::kCredits * (one.header.size() + one.blob.size() + 10))
      << "the rest was not opened";
  expect_kept(*peer.receiver, 1, FakeSender::kCredits);
  for (std::uint32_t back = 0; back < FakeSender::kCredits;)
    back += decode_credit(peer.receive(MessageType::kCredit).at(1)).captures;
  peer.say(kept(kSent));  // what was dropped is missed
  EXPECT_TRUE(eventually([&] { return peer.receiver->stats().rejected_by_reason.contains("gap"); }));
  EXPECT_EQ(peer.welcome().held.at("s").received, static_cast<std::uint64_t>(FakeSender::kCredits));
  peer.say(kept(FakeSender::kCredits + 1));
  expect_kept(*peer.receiver, FakeSender::kCredits + 1, FakeSender::kCredits + 1);
}

TEST(HostileSender, HellosThatAreNotAnsweredGiveNoMoreThanTwiceTheCredits) {
  FakeSender peer;
  peer.welcome();
  peer.say(kept(3));  // a gap: it says hello again, and again
  for (int i = 0; i < 4; ++i) peer.hear_hello();
  constexpr std::uint64_t kSent = 100;
  for (std::uint64_t sequence = 1; sequence <= kSent; ++sequence) peer.say(kept(sequence));
  ASSERT_TRUE(eventually([&] {
    const ReceiverStats stats = peer.receiver->stats();
    return stats.kept + stats.rejected_messages >= kSent + 1;
  }));
  EXPECT_LE(peer.receiver->stats().kept, 2u * FakeSender::kCredits);
}

TEST(HostileSender, LiveFramesCostCreditsToo) {
  FakeSender peer;
  peer.welcome();
  const EncodedCapture frame = encode_capture(sample_capture("s", 1), MessageType::kLive, Codec::kRaw);
  for (int i = 0; i < 100; ++i) peer.say(frame);
  ASSERT_TRUE(eventually([&] {
    const ReceiverStats stats = peer.receiver->stats();
    return stats.live + stats.rejected_messages >= 100;
  }));
  EXPECT_EQ(peer.receiver->stats().live, static_cast<std::uint64_t>(FakeSender::kCredits));
}

TEST(HostileSender, ACaptureOfAnotherSessionThanTheWelcomesIsRefused) {
  FakeSender peer;
  peer.welcome();
  peer.say(encode_capture(sample_capture("another", 1), MessageType::kKeep, Codec::kRaw));
  ASSERT_TRUE(eventually([&] { return peer.receiver->stats().rejected_by_reason.contains("source_session"); }));
  EXPECT_FALSE(peer.welcome().held.contains("another")) << "nothing grows by what a sender makes up";
  peer.say(kept(1));
  expect_kept(*peer.receiver, 1, 1);
}

TEST(HostileSender, AFirstSequenceThatCannotBeReachedIsRefused) {
  FakeSender peer;
  for (const std::uint64_t first : {std::uint64_t{1} << 63, ~std::uint64_t{0}}) {
    peer.welcome(first);
    ASSERT_TRUE(
        eventually([&] { return peer.receiver->stats().rejected_by_reason.contains("welcome.first_sequence"); }));
    EXPECT_EQ(peer.receiver->stats().missing, 0u);
  }
  peer.welcome();
  peer.say(kept(1));
  expect_kept(*peer.receiver, 1, 1);
}

TEST(HostileSender, RandomMessagesAreCountedAndTheLinkGoesOn) {
  FakeSender peer;
  peer.welcome();
  std::mt19937 random(9);
  int sent = 0;
  for (int round = 0; round < 500; ++round) {
    const EncodedCapture good =
        encode_capture(sample_capture("s", 1), round % 2 ? MessageType::kKeep : MessageType::kLive, Codec::kRaw);
    std::vector<Bytes> parts{good.envelope, good.header, good.blob};
    if (round % 5 == 0) parts.resize(1 + random() % 2);
    if (round % 7 == 0) parts.resize(5);
    Bytes& part = parts[random() % parts.size()];
    if (part.empty())
      part.push_back(1);
    else
      part[random() % std::min<std::size_t>(part.size(), 8)] ^= static_cast<std::uint8_t>(1 + random() % 255);
    peer.send(parts);
    ++sent;
    peer.receiver->next(1ms);  // gives a credit for the next
  }
  // Every one is accounted for, whatever became of it.
  EXPECT_TRUE(eventually([&] {
    while (peer.receiver->next(0ms)) {
    }
    const ReceiverStats stats = peer.receiver->stats();
    return stats.rejected_messages + stats.live + stats.kept + stats.duplicates >= static_cast<std::uint64_t>(sent);
  }));
  EXPECT_GT(peer.receiver->stats().rejected_messages, 100u);
}

TEST(HostileReceiver, AnotherVersionIsRefusedNamingBoth) {
  FakeReceiver peer;
  peer.say(MessageType::kHello, Hello{"reconstructor", 2, {}, 0}, 3);
  EXPECT_THAT(peer.hear_refusal(), AllOf(HasSubstr("version 3"), HasSubstr("version 1")));
  EXPECT_EQ(peer.sender.stats().rejected_messages, 1u);
  EXPECT_THAT(peer.sender.stats().last_refusal, HasSubstr("version 3"));
  EXPECT_FALSE(peer.sender.stats().peer_connected);
}

TEST(HostileReceiver, CreditWithoutHelloGetsNoData) {
  FakeReceiver peer;
  keep(peer.sender, 1, 1);
  peer.say(MessageType::kCredit, Credit{5});
  EXPECT_THAT(peer.hear_refusal(), HasSubstr("hello"));
  EXPECT_EQ(peer.sender.stats().delivered, 0u);
}

TEST(HostileReceiver, NoMoreIsSentThanThereAreCredits) {
  FakeReceiver peer;
  keep(peer.sender, 1, 10);
  peer.say(MessageType::kHello, Hello{"reconstructor", 3, {}, 0});
  for (int i = 0; i < 3; ++i) ASSERT_EQ(peer.receive(MessageType::kKeep).size(), 3u);
  peer.socket.set(zmq::sockopt::rcvtimeo, 100);
  EXPECT_TRUE(peer.receive(MessageType::kKeep).empty());
  peer.say(MessageType::kCredit, Credit{1});
  EXPECT_EQ(peer.receive(MessageType::kKeep).size(), 3u);
  EXPECT_TRUE(peer.receive(MessageType::kKeep).empty());
}

TEST(HostileReceiver, AnAcknowledgementOfAnotherSourceIsHarmless) {
  FakeReceiver peer;
  keep(peer.sender, 1, 3);
  peer.say(MessageType::kHello, Hello{"reconstructor", 0, {}, 0});
  peer.say(MessageType::kAck, Ack{"other", 99, true});
  peer.receive(MessageType::kWelcome);
  EXPECT_EQ(peer.sender.stats().acknowledged, 0u);
  EXPECT_FALSE(peer.sender.finish(50ms));
}

constexpr std::uint64_t kNeverSent[] = {3, 1'000'000, std::uint64_t{1} << 63, ~std::uint64_t{0}};

TEST(HostileReceiver, AnAcknowledgementOfWhatWasNeverSentIsRefusedAndReleasesNothing) {
  for (const std::uint64_t sequence : kNeverSent) {
    FakeReceiver peer;
    keep(peer.sender, 1, 5);
    peer.say(MessageType::kHello, Hello{"reconstructor", 2, {}, 0});
    for (int i = 0; i < 2; ++i) ASSERT_EQ(peer.receive(MessageType::kKeep).size(), 3u);
    peer.say(MessageType::kAck, Ack{"s", sequence, true});
    EXPECT_THAT(peer.hear_refusal(), AllOf(HasSubstr("ack.durable"), HasSubstr(std::to_string(sequence))));
    EXPECT_EQ(peer.sender.stats().acknowledged, 0u);
    EXPECT_EQ(peer.sender.stats().rejected_messages, 1u);
    peer.say(MessageType::kAck, Ack{"s", 2, false});  // what is true is believed still
    peer.say(MessageType::kCredit, Credit{3});
    for (int i = 0; i < 3; ++i)
      ASSERT_EQ(peer.receive(MessageType::kKeep).size(), 3u) << "what was not sent still comes";
    EXPECT_EQ(peer.sender.stats().acknowledged, 2u);
  }
}

TEST(HostileReceiver, AHelloThatHoldsWhatWasNeverSentIsRefused) {
  for (const std::uint64_t sequence : kNeverSent) {
    for (const bool durable : {true, false}) {
      FakeReceiver peer;
      keep(peer.sender, 1, 3);
      const HeldCaptures held{.durable = durable ? sequence : 0, .received = durable ? 0 : sequence};
      peer.say(MessageType::kHello, Hello{"reconstructor", 5, {{"s", held}}, 0});
      EXPECT_THAT(peer.hear_refusal(), HasSubstr(durable ? "hello.held.durable" : "hello.held.received"));
      EXPECT_FALSE(peer.sender.stats().peer_connected);
      EXPECT_EQ(peer.sender.stats().acknowledged, 0u);
      peer.say(MessageType::kHello, Hello{"reconstructor", 5, {}, 0});
      for (int i = 0; i < 3; ++i) ASSERT_EQ(peer.receive(MessageType::kKeep).size(), 3u);
    }
  }
}

TEST(HostileReceiver, OfADataSetThatIsStreamedAgainNoMoreIsBelievedThanItHas) {
  SenderOptions options = sender_options();
  options.sent_before = 10;
  FakeReceiver peer(options);
  peer.say(MessageType::kHello, Hello{"reconstructor", 5, {{"s", {11, 11}}}, 0});
  EXPECT_THAT(peer.hear_refusal(), AllOf(HasSubstr("hello.held.durable"), HasSubstr("11"), HasSubstr("10")));
  peer.say(MessageType::kHello, Hello{"reconstructor", 5, {{"s", {10, 10}}}, 0});
  ASSERT_EQ(peer.receive(MessageType::kWelcome).size(), 2u);
  keep(peer.sender, 1, 10);
  EXPECT_TRUE(eventually([&] { return peer.sender.stats().acknowledged == 10; }));
}

TEST(HostileReceiver, AQuestionAboutTheClockIsAnsweredAndChangesNothing) {
  FakeReceiver peer;
  keep(peer.sender, 1, 3);
  peer.say(MessageType::kHello, Hello{"reconstructor", 1, {}, 7});
  ASSERT_EQ(peer.receive(MessageType::kKeep).size(), 3u);
  peer.say(MessageType::kCredit, Credit{0, 4711});
  const Welcome answer = decode_welcome(peer.receive(MessageType::kWelcome).at(1));
  EXPECT_EQ(answer.hello_clock_ns, 4711);
  EXPECT_EQ(peer.sender.stats().delivered, 1u);
  peer.say(MessageType::kCredit, Credit{2});
  for (int i = 0; i < 2; ++i) EXPECT_EQ(peer.receive(MessageType::kKeep).size(), 3u);
  EXPECT_EQ(peer.sender.stats().resent, 0u);
}

TEST(HostileReceiver, RandomMessagesAreRefusedAndTheSenderGoesOn) {
  FakeReceiver peer;
  std::mt19937 random(10);
  for (int round = 0; round < 500; ++round) {
    std::vector<Bytes> parts(1 + random() % 4);
    for (Bytes& part : parts) {
      part.resize(random() % 40);
      for (std::uint8_t& b : part) b = static_cast<std::uint8_t>(random());
    }
    if (round % 2) {  // a good envelope, so that what is behind it is looked at
      const auto envelope = encode_envelope(static_cast<MessageType>(random() % 12));
      parts[0].assign(envelope.begin(), envelope.end());
    }
    peer.send(parts);
  }
  peer.say(MessageType::kHello, Hello{"reconstructor", 2, {}, 7});
  const auto welcome = peer.receive(MessageType::kWelcome);
  ASSERT_EQ(welcome.size(), 2u);
  EXPECT_GT(peer.sender.stats().rejected_messages, 300u);
  keep(peer.sender, 1, 1);
  EXPECT_EQ(peer.receive(MessageType::kKeep).size(), 3u);
}

TEST(HostileReceiver, AFloodFromAStrangerDoesNotDisturbTheLink) {
  FakeReceiver stranger;
  CaptureReceiver receiver(receiver_options(stranger.sender.endpoint()));
  ASSERT_TRUE(eventually([&] { return receiver.stats().connected; }));
  std::jthread flood([&](const std::stop_token& stop) {
    stranger.socket.set(zmq::sockopt::sndtimeo, 10);
    for (int i = 0; i < 20'000 && !stop.stop_requested(); ++i) stranger.send({Bytes(100, 0xAB), Bytes(1000, 1)});
  });
  keep(stranger.sender, 1, 60);
  expect_kept(receiver, 1, 60);
}

}  // namespace
}  // namespace sheen
