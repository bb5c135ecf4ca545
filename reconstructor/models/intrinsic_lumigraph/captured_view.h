// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/camera/posed_camera.h"
#include "common/image/image.h"

namespace sheen {

/// The images that one camera took, each in another light.
struct CapturedView {
  PosedCamera from;
  std::vector<int> lights;       ///< of the light set, ascending
  std::vector<ImageF> radiance;  ///< per light: linear RGB in a light of brightness 1
  std::vector<ImageU8> arrives;  ///< per light: 255 where its light arrives, 0 in shadow; between: an edge, or unknown
  ImageF depth;                  ///< z in camera coordinates, metres; 0 where no surface is known
  ImageF normals;                ///< unit, object frame; empty where they are not known
};

}  // namespace sheen
