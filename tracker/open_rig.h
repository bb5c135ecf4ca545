// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/capture/rig_motion.h"
#include "tracker/rig_config.h"
#include "tracker/rig_tracking.h"

namespace sheen {

/// The cameras of a rig's file, open and with what their frames are tracked with: all, or none. `frames`: of each, 0 is
/// all that come. Throws ConfigError and DeviceError that name the camera, FileError.
std::vector<TrackedCamera> open_cameras(const RigConfig& config, std::uint64_t frames);

/// What changes between the captures: the source knows it of its files, the rig's file says it of a camera. Several
/// cameras are several places.
RigMotion motion_of(const std::vector<TrackedCamera>& cameras);

}  // namespace sheen
