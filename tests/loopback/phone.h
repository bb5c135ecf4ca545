// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/simulation/rig_recording.h"
#include "tests/support/mjpeg_server.h"

namespace sheen::testing {

/// What the lens of a telephone makes of light by itself: the factor on a frame's linear light, per channel.
using Gains = std::array<double, 3>;
using GainOfFrame = std::function<Gains(std::size_t)>;

/// The frames of a recording as a telephone's camera app sends them: sRGB, JPEG of quality 90.
std::vector<std::string> jpegs_of(const RigRecording& recording, const GainOfFrame& gain = {});

/// They come one after the other, each so many times, again and again.
MjpegServer::Picture again_and_again(std::vector<std::string> pictures, std::uint64_t times_each = 1);

}  // namespace sheen::testing
