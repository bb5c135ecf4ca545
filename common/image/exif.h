// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

namespace sheen {

/// How a photograph was exposed, as far as its EXIF data say.
struct ExifExposure {
  double exposure_s = 0;
  double iso = 0;       ///< 0 = not said
  double f_number = 0;  ///< 0 = not said
};

/// From the bytes of a JPEG (APP1 segment), PNG (eXIf chunk) or WebP (EXIF chunk), all of them: PNG and WebP have it
/// before or behind the pixels. Empty where there is no exposure time, or no sense in
/// it.
std::optional<ExifExposure> read_exif_exposure(std::string_view file);

/// By how much a picture must be rotated (and mirrored) to be looked at: 1..8 as the standard numbers them, 1 as it
/// is stored, which is also the answer where nothing is said.
int read_exif_orientation(std::string_view file);

/// Whether it says that the colours are not those of sRGB, as cameras do that are set to Adobe RGB.
bool exif_says_other_colours(std::string_view file);

}  // namespace sheen
