// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/light_rig_capture.h"

#include <string>

#include "common/image/color.h"

namespace sheen {

Capture rig_capture(const PosedCamera& from, const LightState& light, const ImageF& radiance, std::uint64_t sequence,
                    Purpose purpose) {
  const ImageU8 bytes = to_srgb8(radiance);
  Capture capture{.source_session = "rig", .sequence = sequence, .name = "image " + std::to_string(sequence)};
  capture.camera = from.camera;
  capture.image = {.format = PixelFormat::kRGB8,
                   .transfer = Transfer::kSrgb,
                   .width = bytes.width(),
                   .height = bytes.height(),
                   .stride = 3 * static_cast<std::size_t>(bytes.width()),
                   .bytes = {bytes.data(), bytes.data() + bytes.size()}};
  capture.pose.status = PoseStatus::kGiven;
  capture.pose.camera_from_object = from.camera_from_object;
  capture.light = light;
  capture.purpose = purpose;
  return capture;
}

}  // namespace sheen
