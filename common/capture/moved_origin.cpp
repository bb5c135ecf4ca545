// SPDX-License-Identifier: Apache-2.0
#include "common/capture/moved_origin.h"

namespace sheen {

namespace {

void move(const Eigen::Vector3d& origin, Rigid3& camera_from_object) {
  camera_from_object.translation += camera_from_object.rotation * origin;
}

}  // namespace

PosedCamera in_frame_at(const Eigen::Vector3d& origin, PosedCamera camera) {
  move(origin, camera.camera_from_object);
  return camera;
}

LightState in_frame_at(const Eigen::Vector3d& origin, LightState light) {
  if (light.kind == LightKind::kPoint) light.position -= origin;
  return light;
}

Capture in_frame_at(const Eigen::Vector3d& origin, Capture capture) {
  move(origin, capture.pose.camera_from_object);
  capture.light = in_frame_at(origin, capture.light);
  return capture;
}

}  // namespace sheen
