// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/image/exr.h"

namespace sheen {

/// Brings linear red, green and blue, the first three channels, from the primaries and the white that an EXR file names
/// to those of sRGB (ITU-R BT.709), in place; white stays white (Bradford's adaptation), and what is outside of sRGB's
/// gamut is clipped at 0. A file that names none has sRGB's. Throws Error where what it names are no primaries.
void to_srgb_primaries(const ExrAttributes& attributes, ImageF& image);

}  // namespace sheen
