// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/training_images.h"

#include <vector>

#include "reconstructor/radiance/capture_rules.h"

namespace sheen {

RefinementImages training_images(const CaptureSet& captures, int hold_out_every) {
  RefinementImages images{.read = {}, .cameras = {}, .masked = true};
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < captures.size; ++i) {
    const Capture capture = captures.read(i);
    if (is_held_out(capture, hold_out_every) || !capture.pose.usable()) continue;
    used.push_back(i);
    images.cameras.push_back({capture.camera, capture.pose.camera_from_object});
    images.masked = images.masked && !capture.mask.empty();
  }
  images.read = [read = captures.read, used](std::size_t i) { return read(used[i]); };
  return images;
}

}  // namespace sheen
