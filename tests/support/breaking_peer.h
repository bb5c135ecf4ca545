// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <thread>

#include "tests/support/cutting_relay.h"
#include "tests/support/link.h"
#include "tests/support/patience.h"

namespace sheen::testing {

inline int port_of(const std::string& endpoint) {
  return std::stoi(endpoint.substr(endpoint.rfind(':') + 1));
}
inline std::string address_of(int port) {
  return "tcp://127.0.0.1:" + std::to_string(port);
}

/// What is held back of such a socket has heartbeats behind its messages.
inline void send_heartbeats(zmq::socket_t& socket) {
  socket.set(zmq::sockopt::linger, 0);
  socket.set(zmq::sockopt::heartbeat_ivl, 20);
  socket.set(zmq::sockopt::heartbeat_timeout, 60'000);
  socket.set(zmq::sockopt::sndhwm, 0);
}

/// Many small messages, heartbeats, and then nothing but a reset. On a machine that is so busy that the other end hangs
/// up meanwhile, it was broken off already.
inline void break_off(RawPeer& peer, CuttingRelay& relay) {
  constexpr int kMany = 1500;  // more than any limit on what waits has room for
  relay.hold();
  for (int i = 0; i < kMany; ++i) ASSERT_TRUE(peer.send({{1}}));
  std::size_t before = 0;
  const auto end = std::chrono::steady_clock::now() + kPatienceFactor * std::chrono::seconds(60);
  for (int pings = 0; pings < 3 && relay.holds();) {
    ASSERT_LT(std::chrono::steady_clock::now(), end) << "no heartbeats come";
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    pings += relay.held() > before;
    before = relay.held();
  }
  relay.cut();
}

}  // namespace sheen::testing
