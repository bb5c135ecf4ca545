// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/image/cutout.h"

namespace sheen {

/// The picture in an OpenEXR file, linear RGB: R, G, B without a layer; else the layer or part that is called combined,
/// beauty, rgba or the like, or the only one; else its only channel or Y, three times. Ambient occlusion, normals or
/// depth are no picture: a file that leaves it open is refused, with the list of its layers.
///
/// It has the size of the display window; what the data window does not cover is black and not of the object, and what
/// lies beyond is left off. Colours of other primaries than sRGB's (attribute chromaticities) are converted. Alpha is
/// the mask (`mask_of_alpha`), by which colours, premultiplied as the format has them, are divided. Throws FileError.
MaskedImage read_exr_picture(const std::filesystem::path& path);

/// Its size, without its pixels. Throws FileError.
ImageSize read_exr_picture_size(const std::filesystem::path& path);

}  // namespace sheen
