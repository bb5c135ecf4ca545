// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sheen {

/// From what a vertex of a found shape is known.
enum class ShapeEvidence : std::uint8_t {
  kGuessed = 0,  ///< nothing shows it: the underside, or a place that no image sees
  kOutline = 1,  ///< outlines alone bound it
  kSeen = 2,     ///< two images or more agree about it
};

}  // namespace sheen
