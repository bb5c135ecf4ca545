// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <vector>

#include "common/capture/capture.h"
#include "common/simulation/rig_recording.h"

namespace sheen {

/// Which frame of a recording a camera sent under which id. Ids come again when a camera restarts, so one id may stand
/// for several frames.
using SentFrames = std::multimap<std::uint64_t, std::size_t>;

/// Reads lines of "frame_id,rig_index", as the camera server writes them. Throws FileError naming the line.
SentFrames read_sent_frames(const std::filesystem::path& log);

struct PoseErrors {
  std::vector<double> centre_mm;     ///< per capture: distance of the camera's centre from the truth
  std::vector<double> rotation_deg;  ///< per capture
  std::size_t unmatched = 0;         ///< captures whose frame id was never sent
};

/// Adds the error of one tracked capture; of several frames sent under its id the nearest one is taken.
void add_pose_error(const Capture& capture, const RigRecording& recording, const SentFrames& sent, PoseErrors& errors);

}  // namespace sheen
