// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace sheen {

/// The colour space that a JPEG, PNG or WebP file says it has, where that is not sRGB: "Display P3", the name that its
/// ICC profile has, or where the file says so. Empty: sRGB, or nothing is said. By the profile's primaries and its
/// value at half of the range, not by its name; a PNG's gAMA and cHRM count where it has no profile, then EXIF.
std::string other_colour_space(std::string_view file);

}  // namespace sheen
