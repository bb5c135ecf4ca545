// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/image/cutout.h"
#include "common/image/image.h"
#include "common/image/raw_image.h"

namespace sheen {

/// Reads JPEG, PNG, WebP (8 bit: grey or RGB, sRGB; of 16 bits the upper 8) or EXR (`read_exr_picture`). An alpha is
/// the mask; colours are not multiplied by it. An EXIF orientation is not applied: poses belong to the pixels as they
/// are stored. Throws FileError, for damaged data too.
MaskedImage read_masked_image(const std::filesystem::path& path);
/// Without the mask.
RawImage read_image(const std::filesystem::path& path);

/// Of such a file, without decoding its pixels. Throws FileError.
ImageSize read_image_size(const std::filesystem::path& path);

/// A picture that was drawn to be a mask (`mask_of_drawing`; JPEG, PNG, WebP): 255 on the object, else 0. Throws
/// FileError.
ImageU8 read_mask(const std::filesystem::path& path);

/// 1 or 3 channels, or 4: colours with alpha, which are not multiplied by it. Lossless. Throws FileError.
void write_png(const std::filesystem::path& path, const ImageU8& image);

/// JPEG bytes of an 8-bit grey or RGB image, quality 1..100.
std::vector<std::uint8_t> encode_jpeg(const ImageU8& image, int quality);

}  // namespace sheen
