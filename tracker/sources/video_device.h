// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tracker/sources/device_feed.h"
#include "tracker/sources/video_controls.h"

namespace sheen {

/// One connection to a V4L2 device, /dev/videoN. Not thread-safe. A call may take ten seconds when the device hangs.
class VideoDevice : public DeviceConnection {
 public:
  /// Sets size and frame rate, fixes exposure, gain, white balance and focus (`lock_video_device`). Throws DeviceError,
  /// also for what does not stay as it is set: what, asked and got.
  VideoDevice(const std::string& path, const SourceSettings& settings);
  ~VideoDevice() override;

  std::optional<Frame> read() override;
  double frame_rate_hz() const override;
  /// What was set or switched off so that it stays, with what the device says of it.
  const std::vector<LockedFeature>& locks() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Whether a source's target names a device, and not a file.
bool is_video_device(const std::string& path);

}  // namespace sheen
