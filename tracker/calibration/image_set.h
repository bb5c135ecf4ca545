// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/image/image.h"
#include "common/image/raw_image.h"

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

/// An image to find things in.
struct GreyImage {
  ImageU8 grey;  ///< as it is stored
  ImageU8
      light;  ///< proportional to light, for edges: the middle of a blurred edge is where half its light is. In
              ///< encoded values it lies elsewhere, and black squares look smaller by a third of a pixel on each side.
};

GreyImage grey_image(const RawImage& image);

/// Reads them one by one.
void for_each_image(const ImageSet& images, const std::function<void(std::size_t index, const GreyImage& image)>& see);

}  // namespace sheen
