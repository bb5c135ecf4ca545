// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "common/base/progress.h"
#include "common/camera/posed_camera.h"
#include "common/capture/capture.h"
#include "common/stage/stage_layout.h"

namespace sheen {

/// The captures that a mesh or poses are refined against: none of those that are held out.
struct RefinementImages {
  std::function<Capture(std::size_t)> read;
  std::vector<PosedCamera> cameras;  ///< of each
  bool masked = false;               ///< it is known that each has a mask
  std::optional<StageLayout> stage;  ///< that the object stands on, where a file says so

  /// These of them, in this order.
  RefinementImages some(const std::vector<std::size_t>& numbers) const {
    RefinementImages part{.read = [read = read, numbers](std::size_t i) { return read(numbers[i]); },
                          .cameras = {},
                          .masked = masked,
                          .stage = stage};
    for (const std::size_t i : numbers) part.cameras.push_back(cameras[i]);
    return part;
  }
};

}  // namespace sheen
