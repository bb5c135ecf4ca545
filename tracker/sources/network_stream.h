// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "tracker/sources/device_feed.h"

namespace sheen {

struct StreamSize {
  int width = 0, height = 0;  ///< pixels; 0: any
};

/// One connection to a live stream of the network: MJPEG over HTTP (multipart/x-mixed-replace), RTSP, and what else
/// libavformat reads from http, https, rtsp and rtsps addresses. Frames are sRGB; their time is that of their arrival,
/// and nothing is known of their exposure. Not thread-safe.
class NetworkStream : public DeviceConnection {
 public:
  /// Waits for the first picture, for fifteen seconds at most. `given_up` ends all waiting within 100 ms. Throws
  /// DeviceError: what is wrong with the address (without its password) and what to do; ConfigError: another size than
  /// the one that is expected.
  NetworkStream(const std::string& address, StreamSize expected, std::shared_ptr<const std::atomic<bool>> given_up);
  ~NetworkStream() override;

  StreamSize size() const;
  /// What a person should know of its colours, a sentence; empty: nothing.
  std::string warning() const;

  /// The newest picture that has come: those that were overtaken are not delivered. One that is damaged has no image
  /// and is not complete. Throws DeviceError: the stream has ended, is silent for five seconds, or has another size.
  std::optional<Frame> read() override;
  /// The slowest that counts as alive: networks deliver unevenly, and what streams state of their rate is a guess.
  double frame_rate_hz() const override { return 1; }
  std::uint64_t overtaken() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
