// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/image/image.h"
#include "reconstructor/splats/splats.h"

namespace sheen {

/// How much of each pixel is each splat's.
struct SplatShares {
  struct Share {
    std::uint32_t splat;  ///< index
    float weight;         ///< of its colour, 0..1
  };
  std::vector<std::uint32_t> pixels;  ///< that were asked for: y * width + x
  std::vector<std::size_t> first;     ///< of each of these in `shares`, and the end
  std::vector<Share> shares;          ///< from the front

  std::span<const Share> of(std::size_t pixel) const {
    return std::span(shares).subspan(first[pixel], first[pixel + 1] - first[pixel]);
  }
};

/// As the viewers have it (Kerbl et al. 2023): each Gaussian through its projection's derivative onto the image, 0.3
/// square pixels wider, sorted by the depth of its centre, opaque to at most 0.99, nothing below 1/255. The lens is
/// left out, for the viewers know none. `wanted`: 1 channel, of the camera's size; 0 where a pixel is not asked for;
/// empty: all are.
SplatShares splat_shares(const std::vector<SplatShape>& shapes, const PosedCamera& from, const ImageU8& wanted = {});

/// 4 channels: encoded colours times alpha, and alpha.
ImageF paint_splats(const Splats& splats, const PosedCamera& from);

/// Of each splat, as it is seen from an eye: encoded, 3 x splats.
Eigen::Matrix3Xf splat_colours(const Splats& splats, const Eigen::Vector3f& eye);

}  // namespace sheen
