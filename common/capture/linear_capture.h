// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/capture/capture.h"
#include "common/image/linear_reader.h"

namespace sheen {

/// Reads a capture's image as linear radiance: by its photometry where it has one, else as its transfer, black level
/// and white balance say. The capture must be valid and outlive the reader.
LinearReader linear_reader(const Capture& capture);

/// What is known of what the camera makes of light: "not measured", "response measured, vignette not" or "response and
/// vignette measured".
const char* photometric_knowledge(const Capture& capture);

/// All of it: RGB, 3 channels, 1.0 = white level in the middle of the lens.
ImageF linear_radiance(const Capture& capture);

}  // namespace sheen
