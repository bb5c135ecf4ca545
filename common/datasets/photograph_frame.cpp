// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/photograph_frame.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "common/base/order_statistics.h"

namespace sheen {
namespace {

constexpr double kPlainDistance = 0.5;

/// The direction in the stored picture that is up when it is looked at.
Eigen::Vector3d up_in_picture(int exif_orientation) {
  switch (exif_orientation) {
    case 3:
    case 4:
      return Eigen::Vector3d::UnitY();
    case 5:
    case 6:
      return -Eigen::Vector3d::UnitX();
    case 7:
    case 8:
      return Eigen::Vector3d::UnitX();
    default:
      return -Eigen::Vector3d::UnitY();
  }
}

/// Nearest to the axes of all cameras; where they are nearly parallel and leave it open, near the cameras' middle.
Eigen::Vector3d looked_at(const std::vector<DatasetView>& views) {
  constexpr double kPull = 1e-4;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const DatasetView& view : views) middle += camera_centre(view.camera_from_object);
  middle /= static_cast<double>(views.size());
  Eigen::Matrix3d across = kPull * static_cast<double>(views.size()) * Eigen::Matrix3d::Identity();
  Eigen::Vector3d sum = across * middle;
  for (const DatasetView& view : views) {
    const Eigen::Vector3d axis = view.camera_from_object.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Matrix3d off_axis = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    across += off_axis;
    sum += off_axis * camera_centre(view.camera_from_object);
  }
  return across.ldlt().solve(sum);
}

Eigen::Vector3d up_of(const std::vector<DatasetView>& views) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const DatasetView& view : views)
    up += view.camera_from_object.rotation.conjugate() * up_in_picture(view.exif_orientation);
  constexpr double kUndecided = 1e-6;
  return up.norm() > kUndecided ? Eigen::Vector3d(up.normalized()) : Eigen::Vector3d::UnitZ();
}

}  // namespace

void scale_poses(std::vector<DatasetView>& views, double factor) {
  for (DatasetView& view : views) view.camera_from_object.translation *= factor;
}

void bring_to_plain_frame(std::vector<DatasetView>& views) {
  const Rigid3 old_from_new = {Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up_of(views)),
                               looked_at(views)};
  std::vector<double> distances;
  for (DatasetView& view : views) {
    view.camera_from_object = view.camera_from_object * old_from_new;
    distances.push_back(view.camera_from_object.translation.norm());
  }
  if (const double distance = median(distances); distance > 0) scale_poses(views, kPlainDistance / distance);
}

}  // namespace sheen
