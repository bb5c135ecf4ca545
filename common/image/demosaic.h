// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>

namespace sheen {

/// Sites beside, above and below the wanted ones that `demosaic` looks at.
inline constexpr int kDemosaicReach = 12;

/// Interpolates a colour filter array RGGB, `width` and `height` even, red at (0, 0). A site keeps its own value; what
/// it lacks is predicted from its neighbours by slopes between the colours that are fitted round each site, so that
/// neither grey detail nor colours that vary on their own are blurred (docs/decisions/demosaicing.md). Affine planes,
/// whatever their offsets, are returned exactly. Values are those of `root_encode`.
///
/// `load(y, sites)` is asked for the rows y = -kDemosaicReach ... height + kDemosaicReach - 1 in order, each of
/// width + 2 kDemosaicReach sites from x = -kDemosaicReach; `take(y, red, green, blue)` gets each row of `width`
/// pixels.
void demosaic(int width, int height, const std::function<void(int y, std::span<float> sites)>& load,
              const std::function<void(int y, const float* red, const float* green, const float* blue)>& take);

/// Square root that is steady at black: the noise of a sensor, whose variance grows with the light, is nearly alike.
float root_encode(float linear);
inline constexpr float kRootAtBlack = 0.032f;  ///< the root there, before it is taken off
/// Inverse; below black is black.
inline float root_decode(float encoded) {
  const float root = encoded > 0 ? encoded + kRootAtBlack : kRootAtBlack;
  return root * root - kRootAtBlack * kRootAtBlack;
}

}  // namespace sheen
