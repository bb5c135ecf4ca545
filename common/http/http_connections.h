// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

namespace sheen {

/// Limits for clients, however many and however slow they are.
struct HttpLimits {
  std::chrono::milliseconds request{2000};   ///< for a whole request header, from the connection on
  std::chrono::milliseconds answer{10000};   ///< for taking a whole answer
  std::chrono::milliseconds farewell{1000};  ///< for closing the connection after it
  std::size_t request_bytes = 16384;         ///< a longer header is answered with status 431
  std::size_t connections = 128;
  std::size_t connections_of_an_address = 32;
};

/// The connections of a small HTTP server: one request and one answer each, all on one thread that waits for no single
/// client. A client that sends its request byte by byte delays nobody: when there is no room for another
/// connection, the oldest one is closed. Bodies of requests are not read.
class HttpConnections {
 public:
  /// From a whole request header (with its empty line), and the address it came from, to the whole answer; empty: the
  /// connection is closed. Called on the connections' thread.
  using Answer = std::function<std::string(const std::string& request, const std::string& address)>;

  /// Port 0: any free one. Throws DeviceError: an unknown host, an address that is not this machine's, a port in use.
  HttpConnections(const std::string& host, int port, Answer answer, const HttpLimits& limits = {});
  ~HttpConnections();

  int port() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
