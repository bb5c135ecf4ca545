// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
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
  std::vector<std::uint64_t> unacknowledged() const;

 private:
  class Entrance;
  CaptureSender& sender_;
  std::vector<std::unique_ptr<Entrance>> entrances_;
  mutable std::mutex mutex_;
  std::vector<std::uint32_t> kept_by_;  ///< camera of each keyframe, in the order in which they are acknowledged
};

}  // namespace sheen
