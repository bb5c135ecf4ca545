// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "common/image/cutout.h"

namespace sheen {

/// Decodes a PNG, of 16 bits a channel the upper 8; colours are not multiplied by alpha. Throws Error for damaged data.
Cutout decode_png(std::string_view bytes);
ImageSize decode_png_size(std::string_view bytes);

/// The object by a PNG that was drawn to be a mask: `mask_of_drawing`; 16 bits a channel will do. In a palette the
/// first entry is the background where it is black or where no entry is, whatever colours the others have.
ImageU8 decode_png_mask(std::string_view bytes);

/// Throws Error unless the image has 1, 3 or 4 channels.
std::string encode_png(const ImageU8& image);

}  // namespace sheen
