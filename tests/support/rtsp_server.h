// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>

namespace sheen::testing {

/// What network cameras are: an RTSP server on a port of 127.0.0.1 that sends H.264 over the same TCP connection (RFC
/// 2326, interleaved), to one caller at a time. Picture i is grey with the level 40 + 10 (i % 16).
class RtspServer {
 public:
  RtspServer(int width, int height, std::chrono::milliseconds between);
  ~RtspServer();

  std::string address() const { return "rtsp://127.0.0.1:" + std::to_string(port_) + "/live"; }
  std::uint64_t callers() const { return callers_; }  ///< so far

  std::atomic<bool> hangs_up = false;  ///< ends the connection once

 private:
  void run(const std::stop_token& stop);
  void serve(int caller, const std::stop_token& stop);

  const int width_, height_;
  const std::chrono::milliseconds between_;
  int port_ = 0, listener_ = -1;
  std::atomic<std::uint64_t> callers_ = 0;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace sheen::testing
