// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "reconstructor/shape/shape_measures.h"

namespace sheen {

/// What keeps a found shape from being better, a sentence with what to do.
struct ShapeFinding {
  std::string kind;  ///< "moved", "poses", "images", "outlines", "background", "cut off", "directions", "smooth",
                     ///< "thin" or "underside"
  std::string sentence;
  std::vector<std::string> images = {};  ///< names of those that it is about, where it is about some
  bool passes_with_more_images = false;  ///< so it is nothing to worry about while images come
};
/// The gravest first. What one explains is not named again: an object that moved has outlines that disagree.
std::vector<ShapeFinding> findings_of(const ShapeMeasures& measures);

}  // namespace sheen
