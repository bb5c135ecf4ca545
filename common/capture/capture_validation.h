// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "common/capture/capture.h"

namespace sheen {

inline constexpr std::size_t kMaxPixelBytes = std::size_t(1) << 28;  ///< image and mask together
inline constexpr std::size_t kMaxTags = 4096;

/// Empty when a capture makes sense in every field (enums known, numbers finite and in range, rotation a unit
/// quaternion, covariance symmetric with correlations within one, texts short and UTF-8, sizes in agreement), else the
/// name of the first field that is wrong and why.
std::string validation_error(const Capture& capture);

/// The part that can be said before the pixels are there: formats, sizes and their sum.
std::string size_error(const RawImage& image, int mask_width, int mask_height);

/// Whether `text` is well-formed UTF-8 without control characters.
bool is_plain_text(const std::string& text);

}  // namespace sheen
