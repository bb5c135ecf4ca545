// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "common/image/image.h"

namespace sheen {

/// Reflectance of a view without knowledge of its geometry (Weiss 2001; 001 eq. 5 to 7): of log I the differences
/// between neighbouring pixels, their median over the lights, and the picture whose differences are these by least
/// squares (Neumann borders, by cosine transform). RGB; its brightness is that of the median image.
ImageF estimate_reflectance(std::span<const ImageF> radiance);

/// Threshold that separates the values of a picture best into two classes (Otsu; 001 eq. 8 to 10, with the means of the
/// classes divided by their sizes). `mask`: pixels that count, where not empty.
float otsu_threshold(const ImageF& values, const ImageU8& mask);

}  // namespace sheen
