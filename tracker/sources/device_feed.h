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
  /// Frames since it was opened that came before the latest one read and were left out for newer ones.
  virtual std::uint64_t overtaken() const { return 0; }
};
/// Throws DeviceError.
using OpenDevice = std::function<std::unique_ptr<DeviceConnection>()>;

struct FeedOptions {
  std::string name;         ///< of the device, in the log
  std::size_t waiting = 8;  ///< frames that nobody has taken yet; of more the newest are kept
  /// Between attempts to open the device again: 100 ms at first, twice as long each time, up to this.
  std::chrono::milliseconds longest_pause{100};
};

/// The frames of a device whose calls block, and which may be unplugged. A worker reads, and opens the device again
/// when it is gone; whoever asks waits no longer than he says. Frames that nobody takes in time are dropped, the oldest
/// first, and counted as missed. It begins to read with the first call of `next`. The log says that the device is gone
/// and that it is back.
class DeviceFeed {
 public:
  /// Throws what `open` throws: the device must be there at first.
  explicit DeviceFeed(OpenDevice open, FeedOptions options = {});
  /// Does not wait for a device that hangs.
  ~DeviceFeed();

  std::optional<Frame> next(std::chrono::milliseconds timeout);
  /// Stale when frames have not come for 150 ms, or two frame periods if those are longer.
  SourceState state() const;
  SourceStats stats() const;
  /// Why the device is gone or cannot be opened again; empty when it is open.
  std::string trouble() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace sheen
