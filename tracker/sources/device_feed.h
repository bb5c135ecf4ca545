// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "tracker/sources/frame_source.h"

namespace sheen {

/// A connection to a device that hands out one frame after the other.
class DeviceConnection {
 public:
  virtual ~DeviceConnection() = default;
  /// Waits for the next frame, as long as it takes. Nothing, or DeviceError, when the device is gone.
  virtual std::optional<Frame> read() = 0;
  virtual double frame_rate_hz() const = 0;  ///< 0: unknown
};
/// Throws DeviceError.
using OpenDevice = std::function<std::unique_ptr<DeviceConnection>()>;

/// The frames of a device whose calls block, and which may be unplugged. A worker reads, and opens the device again
/// when it is gone; whoever asks waits no longer than he says. Frames that nobody takes in time are dropped, the oldest
/// first, and counted as missed. It begins to read with the first call of `next`.
class DeviceFeed {
 public:
  /// Throws what `open` throws: the device must be there at first.
  explicit DeviceFeed(OpenDevice open);
  /// Does not wait for a device that hangs.
  ~DeviceFeed();

  std::optional<Frame> next(std::chrono::milliseconds timeout);
  /// Stale when frames have not come for 150 ms, or two frame periods if those are longer.
  SourceState state() const;
  SourceStats stats() const;
  /// Why the device cannot be opened again; empty when it is open.
  std::string trouble() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace sheen
