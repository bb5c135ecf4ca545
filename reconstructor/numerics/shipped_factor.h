// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/numerics/online_svd.h"

namespace sheen {

/// Variance of the noise of a camera's values, sRGB-encoded: about one grey level of 255.
inline constexpr double kCameraVariance = 2e-5f;

/// The factor of a patch as models keep it, of colours in rows 3 * sample + channel: told of a camera's noise, and so
/// in fixed point of 16 and 8 bits between folds.
OnlineSvdOptions shipped_factor(OnlineSvdOptions options = {});

/// Largest entry of |B^T B - I| of the basis as a fold finds it.
double orthogonality_lost(const OnlineSvd& factor);

}  // namespace sheen
