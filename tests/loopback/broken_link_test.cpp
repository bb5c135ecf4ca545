// SPDX-License-Identifier: Apache-2.0
// Peers that break off in the middle of a flood end neither program: what a tracker has is delivered, what a
// reconstructor shows goes on.
#include <gtest/gtest.h>

#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/breaking_peer.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

constexpr int kConnections = 12;

class BrokenLinks : public ::testing::Test {
 protected:
  BrokenLinks() { data_.write(); }
  Words track(const std::string& endpoint) const {
    return patient_run({"--source", "dataset:" + data_.folder.string(), "--endpoint", endpoint});
  }

  const TempFolder temp_;
  const BallDataset data_{.folder = temp_.path() / "data", .views = 6};
  const std::filesystem::path session_ = temp_.path() / "session";
  const std::string endpoint_ = free_address();
};

TEST_F(BrokenLinks, CostATrackerNothing) {
  Process rig(track(endpoint_));
  ASSERT_TRUE(rig.prints("to " + endpoint_, kPatience)) << rig.output();
  CuttingRelay relay(port_of(endpoint_), CuttingRelay::Victim::kCalled);
  for (int i = 0; i < kConnections; ++i) {
    RawPeer stranger(zmq::socket_type::dealer);
    send_heartbeats(stranger.socket);
    stranger.socket.connect(address_of(relay.port()));
    stranger.send({{1}});
    ASSERT_EQ(stranger.receive(MessageType::kRefuse).size(), 2u);
    break_off(stranger, relay);
    ASSERT_TRUE(rig.running()) << rig.output();
  }
  expect_outcome(run_to_end(serve(data_.mesh(), session_, {"--endpoint", endpoint_, "--once"})), 0,
                 {"images added to the model"});
  expect_outcome(wait_to_end(rig), 0, {"6 keyframes sent"});
  EXPECT_EQ(captures_of(session_).size(), 6u);
}

TEST_F(BrokenLinks, CostAReconstructorNothing) {
  RawPeer rogue(zmq::socket_type::router);
  send_heartbeats(rogue.socket);
  rogue.socket.bind(kAnyPort);
  CuttingRelay relay(port_of(rogue.socket.get(zmq::sockopt::last_endpoint)), CuttingRelay::Victim::kCaller);
  Process desk(serve(data_.mesh(), session_, {"--endpoint", endpoint_, "--endpoint", address_of(relay.port())}));
  for (int i = 0; i < kConnections; ++i) {
    const Hello hello = decode_hello(rogue.receive(MessageType::kHello).at(1));
    rogue.say(MessageType::kWelcome, Welcome{"rogue", 1, hello.clock_ns, hello.clock_ns});
    break_off(rogue, relay);
    ASSERT_TRUE(desk.running()) << desk.output();
  }
  expect_outcome(run_to_end(track(endpoint_)), 0, {"6 keyframes sent"});
  EXPECT_TRUE(wait_for_captures(session_, 6));
  desk.signal(SIGINT);
  expect_outcome(wait_to_end(desk), 0, {"images added to the model"});
}

}  // namespace
}  // namespace sheen::testing
