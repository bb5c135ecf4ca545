// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace sheen {

inline constexpr int kTagCells = 8;      ///< cells along the side of a tag36h11's black square, its border included
inline constexpr int kTagIdCount = 587;  ///< ids of tag36h11 are 0..586

/// Cells of a tag's black square, seen upright: `white[row][column]`, row 0 at the top. The outermost cells are black.
struct TagPattern {
  std::array<std::array<bool, kTagCells>, kTagCells> white{};
};

/// The pattern of a tag36h11. Throws ConfigError for an id outside 0..586.
TagPattern tag_pattern(int id);

}  // namespace sheen
