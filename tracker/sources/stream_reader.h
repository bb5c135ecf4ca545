// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "tracker/sources/packet_queue.h"

struct AVStream;

namespace sheen {

/// The packets of one connection to a live stream of the network, as libavformat reads them.
class StreamReader {
 public:
  /// Ten seconds at most. `given_up` ends all waiting within 100 ms. Throws DeviceError: what is wrong with the address
  /// (named without its password) and what to do.
  StreamReader(const std::string& address, std::shared_ptr<const std::atomic<bool>> given_up);
  ~StreamReader();

  /// Of its pictures; lives as long as this.
  const AVStream& stream() const;
  /// The next packet of `stream`; null when it has ended, sends nothing for five seconds, or was given up.
  PacketPtr read();
  /// After that: a sentence whose subject is the stream.
  std::string why_ended() const;
  /// Ends a `read` on another thread within 100 ms.
  void give_up();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
