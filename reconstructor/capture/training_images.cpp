// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/training_images.h"

#include <map>
#include <utility>
#include <vector>

#include "reconstructor/radiance/capture_rules.h"

namespace sheen {

PosedImages posed_images(const CaptureSet& captures, int hold_out_every) {
  PosedImages posed{.images = {.read = {}, .cameras = {}, .masked = true, .stage = captures.stage},
                    .training = {},
                    .held_out = {},
                    .captures = {}};
  std::vector<std::size_t>& used = posed.captures;
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

CaptureSet with_poses_of(const PosedImages& posed, CaptureSet captures) {
  std::map<std::size_t, Rigid3> poses;
  for (std::size_t i = 0; i < posed.captures.size(); ++i)
    poses[posed.captures[i]] = posed.images.cameras[i].camera_from_object;
  captures.read = [read = std::move(captures.read), poses = std::move(poses)](std::size_t i) {
    Capture capture = read(i);
    if (const auto pose = poses.find(i); pose != poses.end()) capture.pose.camera_from_object = pose->second;
    return capture;
  };
  return captures;
}

RefinementImages training_images(const CaptureSet& captures, int hold_out_every) {
  const PosedImages posed = posed_images(captures, hold_out_every);
  return posed.images.some(posed.training);
}

}  // namespace sheen
