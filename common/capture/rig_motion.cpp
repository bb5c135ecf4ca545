// SPDX-License-Identifier: Apache-2.0
#include "common/capture/rig_motion.h"

namespace sheen {
namespace {

const char* word(Motion motion) {
  switch (motion) {
    case Motion::kStill:
      return "stands still";
    case Motion::kMoves:
      return "moves";
    case Motion::kUnspecified:
      break;
  }
  return "is unknown";
}

}  // namespace

std::string in_words(const RigMotion& motion) {
  return std::string("the camera ") + word(motion.camera) + " and the light " + word(motion.light);
}

void MotionWatch::look(const PosedCamera& from, const LightState& light) {
  if (!camera_) {
    camera_ = from;
    light_ = light;
    motion_ = {Motion::kStill, Motion::kStill};
    return;
  }
  if (!same_place(*camera_, from)) motion_.camera = Motion::kMoves;
  if (!same_place(light, light_)) motion_.light = Motion::kMoves;
}

}  // namespace sheen
