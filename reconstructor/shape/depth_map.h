// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/image/image.h"

namespace sheen {

/// Where along each pixel's ray the surface may lie: depth along the camera's z axis, metres; 0 to 0 where the ray
/// misses the object.
struct DepthRange {
  ImageF nearest, farthest;
};

/// The surface as one view sees it, pixel by pixel.
struct DepthMap {
  ImageF depth;   ///< along the camera's z axis, metres; 0: not known
  ImageF normal;  ///< 3 channels, unit, in the camera's frame, towards the camera
  ImageF cost;    ///< 1 less the correlation of the best images; of a second search with what depths differ by
};

}  // namespace sheen
