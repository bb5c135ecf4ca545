// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"

namespace sheen {

/// From where an image was taken.
struct PosedCamera {
  Camera camera;
  Rigid3 camera_from_object;

  bool operator==(const PosedCamera&) const = default;
};

/// Whether two images were taken by the same camera from the same place: poses up to rounding (10^-6).
bool same_place(const PosedCamera& a, const PosedCamera& b);

}  // namespace sheen
