// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "common/capture/capture.h"

namespace sheen::testing {

/// A small capture with a value of its own in every field. Pixels, padding bytes and mask follow from `seed`.
Capture sample_capture(PixelFormat format, int width, int height, std::size_t padding, bool with_mask, unsigned seed);

/// The capture of this source and number, 24x16 Bayer without a mask.
Capture sample_capture(const std::string& source_session, std::uint64_t sequence);

}  // namespace sheen::testing
