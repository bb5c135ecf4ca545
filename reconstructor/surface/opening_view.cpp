// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/opening_view.h"

#include <cmath>

namespace sheen {

std::optional<OpeningView> opening_view(const std::vector<PosedCamera>& cameras, const Eigen::Vector3d& centre) {
  constexpr double kAgreement = 0.3;  // length of the mean of unit vectors
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), sum = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> directions;
  for (const PosedCamera& camera : cameras) {
    const Eigen::Vector3d offset = camera_centre(camera.camera_from_object) - centre;
    if (!(offset.norm() > 0)) continue;
    directions.push_back(offset.normalized());
    sum += directions.back();
    up += camera.camera_from_object.rotation.conjugate() * -Eigen::Vector3d::UnitY();
  }
  if (directions.empty()) return std::nullopt;
  up /= static_cast<double>(directions.size());
  OpeningView view{up.norm() > kAgreement ? up.normalized() : Eigen::Vector3d::UnitZ(), directions.front()};
  // The sum of its cosines to all others is greatest, seen from a side: not from straight above.
  double best = -INFINITY;
  for (const Eigen::Vector3d& direction : directions) {
    const double along = direction.dot(view.up), middle = direction.dot(sum) / static_cast<double>(directions.size());
    const double score = middle - along * along;
    if (score <= best) continue;
    best = score;
    view.direction = direction;
  }
  return view;
}

}  // namespace sheen
