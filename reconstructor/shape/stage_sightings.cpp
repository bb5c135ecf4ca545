// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/stage_sightings.h"

#include "common/base/order_statistics.h"

namespace sheen {

void StageSightings::add(const Capture& capture) {
  const Rigid3 object_from_camera = capture.pose.camera_from_object.inverse();
  for (const TagObservation& tag : capture.tags) {
    if (!tag.used) continue;
    std::array<Eigen::Vector2d, 4> seen;
    bool all = true;
    for (int c = 0; c < 4 && all; ++c) {
      const auto ray = capture.camera.ray(tag.corners[c]);
      const Eigen::Vector3d eye = object_from_camera.translation;
      const Eigen::Vector3d down = ray ? object_from_camera.rotation * *ray : Eigen::Vector3d::Zero();
      all = down.z() < 0;
      if (all) seen[c] = (eye - eye.z() / down.z() * down).head<2>();
    }
    if (!all) continue;
    for (int c = 0; c < 4; ++c)
      for (int axis = 0; axis < 2; ++axis) corners_[tag.id][c][axis].push_back(seen[c][axis]);
  }
}

StageLayout StageSightings::layout() const {
  StageLayout stage;
  for (const auto& [id, corners] : corners_) {
    StageTag tag{.id = id, .corners_object = {}};
    for (int c = 0; c < 4; ++c)
      tag.corners_object[c] = {median(std::vector(corners[c][0])), median(std::vector(corners[c][1])), 0};
    stage.tags.push_back(tag);
  }
  return stage;
}

}  // namespace sheen
