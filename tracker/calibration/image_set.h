// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/image/image.h"

namespace sheen {

/// Images of one camera, by their files.
struct ImageSet {
  std::vector<std::filesystem::path> files;
  std::vector<std::string> names;  ///< of the files without their folder, or as given where two are called the same
  ImageSize size;
};

/// The files given, and of a folder those that are JPEG or PNG, by name. Throws FileError where there is none, where
/// one cannot be read, and where they differ in size.
ImageSet find_images(std::span<const std::filesystem::path> files_or_folders);

/// Reads them one by one, grey, as tags are sought in them.
void for_each_image(const ImageSet& images, const std::function<void(std::size_t index, const ImageU8& grey)>& see);

}  // namespace sheen
