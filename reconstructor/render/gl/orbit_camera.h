// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/geometry/mesh.h"

namespace sheen {

/// Where a picture is taken from.
struct Viewpoint {
  Camera camera;
  Rigid3 camera_from_object;
  /// Towards the light, object frame, unit, for models of moving light; zero: where the model has it.
  Eigen::Vector3d light = Eigen::Vector3d::Zero();

  bool operator==(const Viewpoint&) const = default;
  Eigen::Vector3d eye() const { return camera_centre(camera_from_object); }
};

/// The free camera of a person with a mouse: it circles round a target, one direction up (z, until it is told
/// another), and never rolls.
class OrbitCamera {
 public:
  /// Frames an object from obliquely above.
  void frame(const BoundingSphere& object);
  /// What is up, a unit vector. The eye stays where it is seen from the target in the new frame.
  void set_up(const Eigen::Vector3d& up);
  /// The eye keeps its distance and stands in this direction from the target.
  void look_from(const Eigen::Vector3d& direction);
  /// Puts the eye there; it looks at the target. An eye on the target is ignored.
  void place(const Eigen::Vector3d& eye);
  void orbit(double right_rad, double up_rad);
  /// Moves the target across the picture, in fractions of the picture's height.
  void pan(double right, double up);
  /// Multiplies the distance.
  void dolly(double factor);

  /// A pinhole of this size, vertical field of view 40 degrees or, upright pictures, that horizontally.
  Viewpoint viewpoint(int width, int height) const;

 private:
  Eigen::Vector3d direction() const;  ///< unit, from the target to the eye

  Eigen::Matrix3d frame_ = Eigen::Matrix3d::Identity();  ///< columns: two directions across, and up
  Eigen::Vector3d target_ = Eigen::Vector3d::Zero();
  double radius_ = 1;  ///< of the object: the scale of what is near and far
  double distance_ = 3;
  double azimuth_ = -0.9;
  double elevation_ = 0.5;
};

}  // namespace sheen
