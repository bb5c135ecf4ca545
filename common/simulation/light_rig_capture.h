// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "common/camera/posed_camera.h"
#include "common/capture/capture.h"
#include "common/image/image.h"

namespace sheen {

/// An image of the simulated rig as a data set has it: 8-bit sRGB.
Capture rig_capture(const PosedCamera& from, const LightState& light, const ImageF& radiance, std::uint64_t sequence,
                    Purpose purpose = Purpose::kTraining);

}  // namespace sheen
