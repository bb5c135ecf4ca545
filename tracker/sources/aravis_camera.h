// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tracker/sources/camera_lock.h"
#include "tracker/sources/camera_reset.h"
#include "tracker/sources/frame_source.h"
#include "tracker/sources/source_uri.h"

namespace sheen {

/// One connection to a GigE Vision or USB3 Vision camera. Not thread-safe. Opening an absent camera
/// takes seconds, and so does closing one that has vanished.
class AravisCamera {
 public:
  /// Sets region, pixel format (Bayer before RGB before grey, unless one is asked for), frame rate and packet size;
  /// fixes exposure, gain, white balance and black level (`lock_camera`); first undoes what another program left
  /// (`reset_camera`). Throws DeviceError, also for what does not stay as it is set: feature, asked and got.
  AravisCamera(const std::string& id, const SourceSettings& settings);
  ~AravisCamera();

  /// From here on it delivers. Throws DeviceError.
  void start();
  std::optional<Frame> grab(std::chrono::milliseconds timeout);
  /// Whether the camera has stopped answering its heartbeat.
  bool control_lost() const;
  /// What was set or switched off so that it stays, with what the camera says of it.
  const std::vector<LockedFeature>& locks() const;
  /// What was found otherwise and changed, for a person: "ReverseX was on, is off"; empty: nothing.
  std::string changes() const;
  const Exposure& exposure() const;
  double frame_rate_hz() const;
  std::uint64_t underruns() const;
  std::uint64_t missing_packets() const;
  /// Images that another camera sent to the port of this one: it was told to by a program that has ended, and the
  /// system gave the port anew. None of them is handed out; they are known by their size or format.
  std::uint64_t foreign() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
