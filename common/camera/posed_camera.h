// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"

namespace sheen {

/// From where an image was taken.
struct PosedCamera {
  Camera camera;
  Rigid3 camera_from_object;
};

}  // namespace sheen
