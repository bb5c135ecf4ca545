// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>

struct AVPacket;

namespace sheen {

struct FreePacket {
  void operator()(AVPacket* packet) const;
};
using PacketPtr = std::unique_ptr<AVPacket, FreePacket>;
PacketPtr make_packet();

/// What came of a live stream and was not decoded yet. It never grows into a delay: a picture that is decoded without
/// those before it overtakes them, and where too many wait, all are left out until the next such picture.
class PacketQueue {
 public:
  struct Arrived {
    PacketPtr packet;  ///< null: the stream has ended
    std::int64_t at_ns = 0;
  };

  void put(PacketPtr packet, std::int64_t at_ns);
  /// No more come; says why.
  void end(const std::string& why);
  /// Waits for the next one.
  Arrived take();

  std::size_t waiting() const;
  std::uint64_t overtaken() const;  ///< left out so far
  std::string why_ended() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Arrived> packets_;
  std::uint64_t overtaken_ = 0;
  bool broken_ = false;  ///< what comes cannot be decoded before the next picture that needs no other
  bool ended_ = false;
  std::string why_;
};

}  // namespace sheen
