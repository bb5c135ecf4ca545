// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "common/registration/registration_image.h"

namespace sheen {

/// Images with poses, of a data set or of a session (what was withdrawn or is damaged left out).
struct PosedImages {
  std::size_t size = 0;
  std::function<Capture(std::size_t)> read;
};
/// Throws FileError when the folder is neither.
PosedImages open_posed_images(const std::filesystem::path& folder);

/// Cameras by the images' names. Reads every image of a session.
std::map<std::string, PosedCamera> cameras_by_name(const PosedImages& images);

/// At most `most` that have a pose, spread evenly over all.
std::vector<RegistrationImage> some_images(const PosedImages& images, std::size_t most);

}  // namespace sheen
