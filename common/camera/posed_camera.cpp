// SPDX-License-Identifier: Apache-2.0
#include "common/camera/posed_camera.h"

#include <algorithm>

namespace sheen {

bool same_place(const PosedCamera& a, const PosedCamera& b) {
  constexpr double kRounding = 1e-6;
  const Rigid3 &p = a.camera_from_object, &q = b.camera_from_object;
  return a.camera == b.camera && p.rotation.angularDistance(q.rotation) <= kRounding &&
         (p.translation - q.translation).norm() <= kRounding * std::max(p.translation.norm(), q.translation.norm());
}

}  // namespace sheen
