// SPDX-License-Identifier: Apache-2.0
// Peers whose connection breaks in the middle of more than anybody has room for: libzmq 4.3.4 ends the process when it
// heeds a limit on what waits, or sends heartbeats, on such a connection.
#include <gtest/gtest.h>

#include <fstream>

#include "common/link/monitor_socket.h"
#include "common/link/transport.h"
#include "tests/support/breaking_peer.h"
#include "tests/support/link.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

using namespace std::chrono_literals;

constexpr int kConnections = 12;

/// Both ends of a link with or without keys. All strangers know the keys of the receiver.
class BrokenLink : public ::testing::TestWithParam<bool> {
 protected:
  BrokenLink() {
    if (!GetParam()) return;
    sender_keys_ = generate_keys(temp_.path(), "tracker");
    receiver_keys_ = generate_keys(temp_.path(), "desk");
    std::ofstream(temp_.path() / "allowed") << receiver_keys_->public_key << " reconstructor desk\n";
  }
  SenderOptions sending() const {
    SenderOptions options = sender_options();
    options.keys = sender_keys_;
    if (options.keys) options.allowlist = temp_.path() / "allowed";
    return options;
  }
  ReceiverOptions receiving(const std::string& endpoint) const {
    ReceiverOptions options = receiver_options(endpoint);
    options.keys = receiver_keys_;
    if (options.keys) options.server_public_key = sender_keys_->public_key;
    return options;
  }
  void arm(zmq::socket_t& socket, bool caller) const {
    send_heartbeats(socket);
    if (!sender_keys_) return;
    socket.set(zmq::sockopt::curve_server, !caller);
    socket.set(zmq::sockopt::curve_secretkey, caller ? receiver_keys_->secret_key : sender_keys_->secret_key);
    if (!caller) return;
    socket.set(zmq::sockopt::curve_publickey, receiver_keys_->public_key);
    socket.set(zmq::sockopt::curve_serverkey, sender_keys_->public_key);
  }
  const TempFolder temp_;
  std::optional<CurveKeys> sender_keys_, receiver_keys_;
};

TEST_P(BrokenLink, CostsASenderNothing) {
  CaptureSender sender(sending());
  keep(sender, 1, 5);
  CuttingRelay relay(port_of(sender.endpoint()), CuttingRelay::Victim::kCalled);
  for (int i = 0; i < kConnections; ++i) {
    RawPeer stranger(zmq::socket_type::dealer);
    arm(stranger.socket, true);
    stranger.socket.connect(address_of(relay.port()));
    stranger.send({{1}});
    ASSERT_EQ(stranger.receive(MessageType::kRefuse).size(), 2u) << "it is through";
    break_off(stranger, relay);
  }
  CaptureReceiver receiver(receiving(sender.endpoint()));
  expect_kept(receiver, 1, 5);
}

/// Who takes the place of a connection leaves it without anybody who hears it.
TEST_P(BrokenLink, WhosePlaceWasTakenCostsASenderNothing) {
  CaptureSender sender(sending());
  keep(sender, 1, 5);
  CuttingRelay relay(port_of(sender.endpoint()), CuttingRelay::Victim::kCalled);
  for (int i = 0; i < 3; ++i) {
    RawPeer first(zmq::socket_type::dealer), second(zmq::socket_type::dealer);
    for (RawPeer* peer : {&first, &second}) {
      arm(peer->socket, true);
      peer->socket.set(zmq::sockopt::routing_id, "the same");
      peer->socket.connect(peer == &first ? address_of(relay.port()) : sender.endpoint());
      peer->send({{1}});
      ASSERT_EQ(peer->receive(MessageType::kRefuse).size(), 2u);
    }
    break_off(first, relay);
    std::this_thread::sleep_for(600ms);  // heartbeats of the sender's own would fall due
  }
  CaptureReceiver receiver(receiving(sender.endpoint()));
  expect_kept(receiver, 1, 5);
}

TEST_P(BrokenLink, CostsAReceiverNothing) {
  RawPeer rogue(zmq::socket_type::router);
  arm(rogue.socket, false);
  rogue.socket.bind(kAnyPort);
  CuttingRelay relay(port_of(rogue.socket.get(zmq::sockopt::last_endpoint)), CuttingRelay::Victim::kCaller);
  CaptureReceiver receiver(receiving(address_of(relay.port())));
  const auto welcome = [&] {
    const Hello hello = decode_hello(rogue.receive(MessageType::kHello).at(1));
    const auto held = hello.held.find("s");
    rogue.say(MessageType::kWelcome, Welcome{"s", 1, hello.clock_ns, hello.clock_ns});
    return held == hello.held.end() ? 0 : held->second.received;
  };
  for (int i = 0; i < kConnections; ++i) {
    welcome();
    break_off(rogue, relay);
  }
  ASSERT_EQ(welcome(), 0u);
  rogue.say(encode_capture(sample_capture("s", 1), MessageType::kKeep, Codec::kRaw));
  expect_kept(receiver, 1, 1);
}

INSTANTIATE_TEST_SUITE_P(Keys, BrokenLink, ::testing::Bool(),
                         [](const auto& which) { return which.param ? "WithKeys" : "WithoutKeys"; });

TEST(BrokenWatcher, CostsAPublisherNothing) {
  MonitorPublisher publisher({.endpoint = kAnyPort});
  CuttingRelay relay(port_of(publisher.endpoint()), CuttingRelay::Victim::kCalled);
  for (int i = 0; i < kConnections; ++i) {
    zmq::context_t context{1};
    zmq::socket_t watcher(context, zmq::socket_type::xsub);
    send_heartbeats(watcher);
    watcher.set(zmq::sockopt::rcvtimeo, 20);
    watcher.connect(address_of(relay.port()));
    watcher.send(zmq::buffer("\1", 1), zmq::send_flags::none);
    publisher.publish({.role = "tracker", .source_session = "s"});
    zmq::message_t status;
    while (!watcher.recv(status)) publisher.publish({.role = "tracker", .source_session = "s"});
    relay.hold();
    for (int topic = 0; topic < 1500; ++topic)
      watcher.send(zmq::buffer(std::string(1, '\1') + std::to_string(topic)), zmq::send_flags::none);
    std::this_thread::sleep_for(100ms);
    relay.cut();
  }
  MonitorSubscriber honest({.endpoint = publisher.endpoint()});
  EXPECT_TRUE(eventually([&] {
    publisher.publish({.role = "tracker", .source_session = "s"});
    return honest.next(20ms).has_value();
  }));
}

TEST(ManyConnections, ThatNobodyHearsAreHungUpOnAndTheLinkGoesOn) {
  CaptureSender sender(sender_options());
  keep(sender, 1, 5);
  zmq::context_t context{1};
  std::vector<zmq::socket_t> strangers;
  constexpr std::size_t kFew = 280;
  ASSERT_TRUE(eventually([&] {
    while (strangers.size() < kFew) {
      strangers.emplace_back(context, zmq::socket_type::dealer);
      strangers.back().set(zmq::sockopt::linger, 0);
      strangers.back().connect(sender.endpoint());
    }
    return sender.stats().hung_up > 0;
  }));
  strangers.clear();
  CaptureReceiver receiver(receiver_options(sender.endpoint()));
  expect_kept(receiver, 1, 5);
}

}  // namespace
}  // namespace sheen::testing
