// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "common/datasets/dataset.h"

namespace sheen {

/// What an image file and its mask are, decoded once.
struct ImageInspection {
  std::string damage;         ///< why it cannot be used; empty: it can
  std::string contents;       ///< hash of both files
  bool alpha = false;         ///< it says by an alpha what is object
  std::string other_colours;  ///< the colour space that the image says it has; empty: sRGB
  bool grey = false;          ///< it has no colours
};

/// Fills what the files say of the view: sizes, exposure, orientation.
ImageInspection inspect(DatasetView& view);

}  // namespace sheen
