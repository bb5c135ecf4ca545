// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "common/image/cutout.h"

namespace sheen {

/// An RGB picture as lossy WebP; quality 0..100. Throws Error.
std::string encode_webp(const ImageU8& rgb, float quality);

/// The same without loss.
std::string encode_webp_lossless(const ImageU8& rgb);

/// Its colours, without an alpha. Throws Error when it is none.
ImageU8 decode_webp(std::string_view bytes);
/// Its colours, not multiplied by alpha, and its alpha. Throws Error.
Cutout decode_webp_cutout(std::string_view bytes);
/// The object by a WebP that was drawn to be a mask: `mask_of_drawing`. Throws Error.
ImageU8 decode_webp_mask(std::string_view bytes);
/// Its size, without its pixels. Throws Error.
ImageSize decode_webp_size(std::string_view bytes);

}  // namespace sheen
