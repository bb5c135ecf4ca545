// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/image/image.h"

namespace sheen {

/// Sum of squared differences and count, so that several images can be pooled.
struct SquaredError {
  double sum = 0;
  std::size_t count = 0;  ///< values, i.e. pixels times channels
  SquaredError& operator+=(const SquaredError& other) {
    sum += other.sum;
    count += other.count;
    return *this;
  }
  /// Against a peak of 255. Infinity when equal; NaN when nothing was compared.
  double psnr_db() const;
};

/// Over pixels where `mask` (1 channel) is non-zero; an empty mask takes all. Sizes must agree.
SquaredError squared_error(const ImageU8& a, const ImageU8& b, const ImageU8& mask);

/// SSIM (Wang et al. 2004: 11x11 Gaussian of sigma 1.5, K = 0.01, 0.03), the mean over channels and over the masked
/// pixels; windows are clipped to the image, not to the mask. NaN when the mask is empty of pixels.
double ssim(const ImageU8& a, const ImageU8& b, const ImageU8& mask);

/// `mask` shrunk by a square of 2 * radius + 1 pixels; the image's border does not count as outside.
ImageU8 erode(const ImageU8& mask, int radius);

}  // namespace sheen
