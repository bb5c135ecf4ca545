// SPDX-License-Identifier: Apache-2.0
// Peers that do not keep to the protocol, or to this version of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "common/errors.h"
#include "common/transport.h"
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
  FakeSender() : RawPeer(zmq::socket_type::router) {
    socket.bind(testing::kAnyPort);
    receiver.emplace(receiver_options(socket.get(zmq::sockopt::last_endpoint)));
  }
  Hello hear_hello() { return decode_hello(receive(MessageType::kHello).at(1)); }
  Hello welcome(std::uint64_t first_sequence = 1, const std::string& session = "s") {
    const Hello hello = hear_hello();
    say(MessageType::kWelcome, Welcome{session, first_sequence, hello.clock_ns, hello.clock_ns + 1'000'000'000});
    return hello;
  }
  std::optional<CaptureReceiver> receiver;
};

/// A receiver played by the test, connected to a real sender.
struct FakeReceiver : RawPeer {
  FakeReceiver() : RawPeer(zmq::socket_type::dealer), sender(sender_options()) { socket.connect(sender.endpoint()); }
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

TEST(HostileSender, TheClocksAreCompared) {
  FakeSender peer;
  peer.welcome();  // its clock is a second ahead
  ASSERT_TRUE(eventually([&] { return peer.receiver->stats().connected; }));
  const ReceiverStats stats = peer.receiver->stats();
  EXPECT_GT(stats.round_trip_ns, 0);
  EXPECT_NEAR(static_cast<double>(stats.clock_offset_ns), 1e9, static_cast<double>(stats.round_trip_ns));
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

TEST(HostileReceiver, AnAcknowledgementOfWhatWasNeverSentOrOfAnotherSourceIsHarmless) {
  FakeReceiver peer;
  keep(peer.sender, 1, 3);
  peer.say(MessageType::kHello, Hello{"reconstructor", 0, {}, 0});
  peer.say(MessageType::kAck, Ack{"other", 99, true});
  peer.receive(MessageType::kWelcome);
  EXPECT_EQ(peer.sender.stats().acknowledged, 0u);
  EXPECT_FALSE(peer.sender.finish(50ms));
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
