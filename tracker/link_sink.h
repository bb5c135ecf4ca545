// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "common/link/transport.h"
#include "tracker/capture_sink.h"

namespace sheen {

/// The link as the cameras of a rig see it: all of them send through it, and it knows whose keyframes have not been
/// acknowledged. Thread-safe.
class LinkSink {
 public:
  /// `sender` must outlive it, and nothing else may keep captures there.
  LinkSink(CaptureSender& sender, std::size_t cameras);
  ~LinkSink();

  CaptureSink& of(std::size_t camera);
  /// By camera: keyframes that the link took and that no receiver has acknowledged.
  std::vector<std::uint64_t> unacknowledged();

 private:
  class Entrance;
  CaptureSender& sender_;
  std::vector<std::unique_ptr<Entrance>> entrances_;
  void forget_acknowledged();

  std::mutex mutex_;
  /// Camera of each keyframe that waits, in the order in which they are acknowledged: no more than the sender retains.
  std::deque<std::uint32_t> waiting_;
  std::uint64_t forgotten_ = 0;  ///< keyframes that were acknowledged
};

}  // namespace sheen
