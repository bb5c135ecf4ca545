// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "common/capture/capture.h"

namespace sheen {

/// Where captures go: the network, or whatever a test puts in its place. The meaning is that of `CaptureSender`.
class CaptureSink {
 public:
  virtual ~CaptureSink() = default;
  /// Delivered at least once, in order. Waits for room; false when there was none until `timeout`.
  virtual bool keep(Capture capture, std::chrono::milliseconds timeout) = 0;
  /// Latest wins; never waits.
  virtual void live(Capture capture) = 0;
};

}  // namespace sheen
