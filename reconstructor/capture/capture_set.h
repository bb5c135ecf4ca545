// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "common/capture/rig_motion.h"
#include "common/datasets/image_account.h"
#include "common/stage/stage_layout.h"
#include "reconstructor/scene/mesh_scale.h"

namespace sheen {

/// Captures in their order, wherever they lie: posed photographs (transforms.json, COLMAP), a list of lights (.lp) or
/// the journal of a session, of which only those that are not withdrawn and not damaged count. Each of a session that
/// is damaged is told to the log.
struct CaptureSet {
  std::size_t size = 0;
  std::size_t withdrawn = 0;
  std::size_t damaged = 0;  ///< or missing
  std::function<Capture(std::size_t)> read;
  std::vector<PosedCamera> cameras;   ///< of a data set all; of a session some
  std::function<RigMotion()> motion;  ///< what moves between them; of a session it reads all
  std::optional<StageLayout> stage;   ///< of a data set: what its `stage.json` says
  std::optional<ImageAccount> files;  ///< of a data set or a list: what became of its image files
  /// Of a data set or a list: the image of each. Of a session empty.
  std::vector<std::filesystem::path> image_files;
};

/// The same captures in the frame of a mesh with this origin.
CaptureSet in_frame_at(const Eigen::Vector3d& origin, CaptureSet captures);

/// Tells on standard error what became of the files of a data set, and what is doubtful about it. Throws FileError when
/// the folder is neither, naming what was looked for.
CaptureSet open_capture_set(const std::filesystem::path& folder);

}  // namespace sheen
