// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace sheen::testing {

/// A TCP connection between two ends of 127.0.0.1 of which what goes to one end, the victim, can be held back,
/// delivered in one piece and followed by a reset at once: as from a peer of which only the bytes matter, whether or
/// not they are encrypted. One connection after the other.
class CuttingRelay {
 public:
  enum class Victim { kCaller, kCalled };
  CuttingRelay(int called_port, Victim victim);
  ~CuttingRelay() = default;

  int port() const { return port_; }
  bool connected() const { return connected_; }
  void hold() { holds_ = true; }
  bool holds() const { return holds_; }  ///< until the connection ends
  std::size_t held() const;
  /// Returns when it is done; the next connection is not held back.
  void cut();

 private:
  void run(const std::stop_token& stop);
  void carry(int caller, int called, const std::stop_token& stop);

  const int called_port_;
  const Victim victim_;
  int listener_ = -1, port_ = 0;
  std::atomic<bool> holds_{false}, cuts_{false}, connected_{false};
  mutable std::mutex mutex_;
  std::vector<std::uint8_t> held_;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace sheen::testing
