// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/model_painter.h"

#include "common/capture/moved_origin.h"

namespace sheen {

PosedCamera ModelPainter::place_of(const PosedCamera& camera) const {
  return in_frame_at(model_.mesh().origin, camera);
}

LightState ModelPainter::light_of(const LightState& light) const {
  return model_.light_kind() == LightKind::kFixed ? LightState{} : in_frame_at(model_.mesh().origin, light);
}

SmoothView ModelPainter::paint(const PosedCamera& camera, const LightState& light) const {
  const PosedCamera from = place_of(camera);
  return rays_.paint_smooth(model_, outlines_, from.camera, from.camera_from_object, light_of(light));
}

}  // namespace sheen
