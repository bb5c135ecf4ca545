// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "common/base/progress.h"
#include "common/camera/posed_camera.h"
#include "common/capture/capture.h"

namespace sheen {

/// The captures that a mesh or poses are refined against: none of those that are held out.
struct RefinementImages {
  std::function<Capture(std::size_t)> read;
  std::vector<PosedCamera> cameras;  ///< of each
  bool masked = false;               ///< it is known that each has a mask

  /// These of them, in this order.
  RefinementImages some(const std::vector<std::size_t>& numbers) const {
    RefinementImages part{
        .read = [read = read, numbers](std::size_t i) { return read(numbers[i]); }, .cameras = {}, .masked = masked};
    for (const std::size_t i : numbers) part.cameras.push_back(cameras[i]);
    return part;
  }
};

}  // namespace sheen
