// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/training_images.h"

#include <vector>

#include "reconstructor/radiance/capture_rules.h"

namespace sheen {

PosedImages posed_images(const CaptureSet& captures, int hold_out_every) {
  PosedImages posed{.images = {.read = {}, .cameras = {}, .masked = true}, .training = {}, .held_out = {}};
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < captures.size; ++i) {
    const Capture capture = captures.read(i);
    if (!capture.pose.usable()) continue;
    (is_held_out(capture, hold_out_every) ? posed.held_out : posed.training).push_back(used.size());
    used.push_back(i);
    posed.images.cameras.push_back({capture.camera, capture.pose.camera_from_object});
    posed.images.masked = posed.images.masked && !capture.mask.empty();
  }
  posed.images.read = [read = captures.read, used](std::size_t i) { return read(used[i]); };
  return posed;
}

RefinementImages training_images(const CaptureSet& captures, int hold_out_every) {
  const PosedImages posed = posed_images(captures, hold_out_every);
  return posed.images.some(posed.training);
}

}  // namespace sheen
