// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace sheen {

/// Rigid transform, named `target_from_source`: `x_target = target_from_source * x_source`. Metres.
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  bool operator==(const Rigid3& other) const {
    return rotation.coeffs() == other.rotation.coeffs() && translation == other.translation;
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return rotation * point + translation; }
  Rigid3 operator*(const Rigid3& other) const {
    return {(rotation * other.rotation).normalized(), rotation * other.translation + translation};
  }
  Rigid3 inverse() const {
    const Eigen::Quaterniond r = rotation.conjugate();
    return {r, -(r * translation)};
  }
  Eigen::Matrix4d matrix() const {
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m.topLeftCorner<3, 3>() = rotation.toRotationMatrix();
    m.topRightCorner<3, 1>() = translation;
    return m;
  }
  /// The rotation part must be orthonormal already; callers validate what comes from files.
  static Rigid3 from_matrix(const Eigen::Matrix4d& m) {
    return {Eigen::Quaterniond(Eigen::Matrix3d(m.topLeftCorner<3, 3>())).normalized(), m.topRightCorner<3, 1>()};
  }
};

/// Origin of the source frame's camera in the object frame: where the eye is.
inline Eigen::Vector3d camera_centre(const Rigid3& camera_from_object) {
  return camera_from_object.inverse().translation;
}

/// The pose of a camera at `eye` that looks at `target`, its image's up direction as near to `up` as can be.
Rigid3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up);

}  // namespace sheen
