// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace sheen::testing {

/// What telephones' camera apps are: an HTTP server on a port of 127.0.0.1 that sends JPEG pictures one after the other
/// as multipart/x-mixed-replace, to one caller at a time.
class MjpegServer {
 public:
  /// The bytes of the picture with this number, from 0; the count goes on over connections.
  using Picture = std::function<std::string(std::uint64_t)>;
  struct Options {
    std::chrono::milliseconds between{20};  ///< two pictures
    bool states_lengths = true;             ///< Content-Length of each picture
    std::string status = "200 OK";
    std::string content_type = "multipart/x-mixed-replace; boundary=picture";
    std::string user_and_password;  ///< "me:secret" is asked for; empty: nobody is asked
    std::string body;               ///< in place of pictures
  };

  explicit MjpegServer(Picture picture);  ///< with the ordinary options
  MjpegServer(Picture picture, Options options);
  ~MjpegServer();

  int port() const { return port_; }
  std::string address(const std::string& user = {}) const;  ///< http://127.0.0.1:PORT/video
  std::uint64_t sent() const { return sent_; }              ///< pictures
  std::uint64_t callers() const { return callers_; }        ///< so far

  std::atomic<bool> silent = false;    ///< keeps the connection, and sends nothing
  std::atomic<bool> refuses = false;   ///< ends the connection, and each new one at once
  std::atomic<bool> hangs_up = false;  ///< ends the connection once

 private:
  void run(const std::stop_token& stop);
  void serve(int caller, const std::stop_token& stop);
  bool lets_in(const std::string& request) const;

  const Picture picture_;
  const Options options_;
  int port_ = 0, listener_ = -1;
  std::atomic<std::uint64_t> sent_ = 0, callers_ = 0;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace sheen::testing
