// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sheen {

/// What a growing model scores on views that it never saw, after so many images: means over the views that judge, and
/// the constant colour's.
struct HeldOutPoint {
  std::uint64_t images = 0;
  double psnr_db = 0, ssim = 0, constant_psnr_db = 0;
};

}  // namespace sheen
