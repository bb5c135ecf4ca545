// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/capture/capture.h"
#include "common/capture/rig_motion.h"
#include "common/datasets/image_account.h"

namespace sheen {

/// Images on disk with their cameras and lights, whichever way they are described: posed photographs (transforms.json,
/// COLMAP) or a list of lights (.lp).
struct StoredImages {
  std::size_t size = 0;
  std::string session;                       ///< of their captures: changes with the description and with any image
  std::vector<PosedCamera> cameras;          ///< of all of them; of a list its one
  std::vector<std::filesystem::path> files;  ///< of each its image
  RigMotion motion;                          ///< what changes between them
  ImageAccount account;                      ///< what became of the files
  std::string summary;                       ///< that in words, lines for a person
  std::string warning;                       ///< what is doubtful about them, a sentence for a person; empty: nothing
  /// Reads one: `read_capture` of the data set or of the list.
  std::function<Capture(std::size_t index)> read;
};

/// Whether a path is that of a list of lights: it ends in .lp, of whichever case.
bool is_light_list(const std::filesystem::path& path);

/// Throws FileError that names what was looked for, also where an image has not the size of its camera.
StoredImages open_stored_images(const std::filesystem::path& path);

}  // namespace sheen
