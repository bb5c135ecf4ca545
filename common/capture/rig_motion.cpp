// SPDX-License-Identifier: Apache-2.0
#include "common/capture/rig_motion.h"

#include <algorithm>

namespace sheen {
namespace {

constexpr double kSame = 1e-6;

bool same(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (a - b).norm() <= kSame * std::max(a.norm(), b.norm());
}

bool same(const PosedCamera& a, const PosedCamera& b) {
  const Rigid3 &p = a.camera_from_object, &q = b.camera_from_object;
  return a.camera == b.camera && same(p.translation, q.translation) && p.rotation.angularDistance(q.rotation) <= kSame;
}

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
  if (!same(*camera_, from)) motion_.camera = Motion::kMoves;
  if (light.kind != light_.kind || !same(light.position, light_.position)) motion_.light = Motion::kMoves;
}

}  // namespace sheen
