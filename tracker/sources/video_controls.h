// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "tracker/sources/camera_lock.h"
#include "tracker/sources/source_uri.h"

namespace sheen {

/// A call to a V4L2 device, as ioctl(2): 0, or -1 with errno.
using DeviceCall = std::function<int(unsigned long request, void* argument)>;

/// What became of a video device's controls.
struct VideoLocks {
  std::vector<LockedFeature> features;  ///< by the names that `v4l2-ctl --list-ctrls` shows
  double exposure_s = 0;                ///< read back; 0 where the device does not tell
};

/// Switches off what changes by itself (exposure, gain, white balance, focus), sets what is asked for, and reads all of
/// it back. A control that the device lacks is listed only where a value was asked for it.
VideoLocks lock_video_device(const DeviceCall& call, const SourceSettings& settings);

}  // namespace sheen
