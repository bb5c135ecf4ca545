// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/image/image.h"

namespace sheen {

/// A map of the light from all around, of latitude and longitude as OpenEXR has it: 3 channels (R, G, B of the file,
/// without a layer), twice as wide as high. A map of cube faces (attribute `envmap`) is converted, with four times the
/// width of a face. Throws FileError, also for a picture that is neither.
ImageF read_exr_environment(const std::filesystem::path& path);

}  // namespace sheen
