// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tracker/sources/frame_source.h"
#include "tracker/sources/source_uri.h"

namespace sheen {

/// One connection to a GigE Vision or USB3 Vision camera that is acquiring. Not thread-safe. Opening an absent camera
/// takes seconds, and so does closing one that has vanished.
class AravisCamera {
 public:
  /// Sets region, pixel format (Bayer before RGB before grey), frame rate and packet size; fixes exposure, gain and
  /// white balance where the camera has them, and reads them back. Throws DeviceError.
  AravisCamera(const std::string& id, const SourceSettings& settings);
  ~AravisCamera();

  std::optional<Frame> grab(std::chrono::milliseconds timeout);
  /// Whether the camera has stopped answering its heartbeat.
  bool control_lost() const;
  const Exposure& exposure() const;
  double frame_rate_hz() const;
  std::uint64_t underruns() const;
  std::uint64_t missing_packets() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
