// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/camera/camera.h"

namespace sheen {

/// A camera as `sheen-tracker calibrate` writes it and a rig's `[camera] file` reads it.
struct CameraFile {
  Camera camera;
  double focal_uncertainty = 0;  ///< standard deviation of the focal length as a part of it; 0: not known
};

/// JSON; throws FileError naming the field.
CameraFile load_camera(const std::filesystem::path& path);
void save_camera(const CameraFile& file, const std::filesystem::path& path);

/// "opencv" or "fisheye", as files name a lens.
const char* lens_name(LensModel lens);

}  // namespace sheen
