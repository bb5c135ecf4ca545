// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <string>
#include <thread>

namespace sheen {

/// A cable between two programs that can be cut: what connects to it on 127.0.0.1 is connected to `target`
/// (tcp://HOST:PORT), and while it is cut no byte passes and no connection ends, as with a real cable.
class TcpRelay {
 public:
  explicit TcpRelay(const std::string& target);
  ~TcpRelay();
  TcpRelay(const TcpRelay&) = delete;
  TcpRelay& operator=(const TcpRelay&) = delete;

  std::string endpoint() const { return "tcp://127.0.0.1:" + std::to_string(port_); }
  void cut() { cut_ = true; }
  void mend() { cut_ = false; }

 private:
  void run(const std::stop_token& stop);

  int target_port_ = 0, port_ = 0, listener_ = -1;
  std::atomic<bool> cut_ = false;
  std::jthread thread_;
};

}  // namespace sheen
