// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/capture/capture.h"

namespace sheen {

/// One frame of a simulated rig as its camera would send it.
struct RigFrame {
  std::filesystem::path raw_file;  ///< width * height bytes of the recording's pixel format
  Rigid3 camera_from_object;       ///< exact, at the middle of the exposure
  double blur_px = 0;              ///< exact length of the motion streak at the object's centre
};

/// A simulated rig rendered to disk: frames for the camera server, and the truth behind them. The folder also is a
/// dataset (`transforms.json`, `images/`, `masks/`, `truth/*.exr`), with `mesh.ply` and `stage.json` beside.
struct RigRecording {
  std::filesystem::path folder;
  Camera camera;
  PixelFormat format = PixelFormat::kBayerRG8;
  double frame_rate_hz = 0;
  Exposure exposure;
  std::vector<RigFrame> frames;
  std::string parameters_hash;  ///< of what it was rendered from: tells whether it must be rendered again

  std::filesystem::path mesh_file() const { return folder / "mesh.ply"; }
  std::filesystem::path stage_file() const { return folder / "stage.json"; }
};

/// Reads and writes `rig.json` in the recording's folder. Throws FileError naming the field. `raw_file` is relative to
/// the folder in the file, and absolute or relative to the current directory, as `folder` is, in memory.
RigRecording load_rig_recording(const std::filesystem::path& folder);
void save_rig_recording(const RigRecording& recording);

}  // namespace sheen
