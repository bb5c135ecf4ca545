// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/camera/camera.h"
#include "common/image/image.h"

namespace sheen {

/// A picture as a pinhole camera would have taken it.
struct UndistortedPicture {
  Camera camera;  ///< of the same focal length, principal point and size
  ImageF linear;  ///< 3 channels; 0 where the lens showed nothing
  ImageU8 mask;   ///< 1 channel, 0 also where the lens showed nothing; empty where all counts
};

/// `linear`: 3 channels, of the camera's size; `mask`: empty or of that size, 0 = ignore. Read by cubic convolution.
UndistortedPicture undistorted(const Camera& camera, const ImageF& linear, const ImageU8& mask);

}  // namespace sheen
