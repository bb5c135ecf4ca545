// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "common/image/image.h"

namespace sheen {

/// Throw Error with the reason (the caller knows the file's name).
ImageU8 decode_jpeg(std::string_view bytes);
ImageSize decode_jpeg_size(std::string_view bytes);

}  // namespace sheen
