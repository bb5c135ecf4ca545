// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "common/camera/rigid3.h"

namespace sheen {

/// How to move from one eye to another on a sphere round the centre, as a person with a camera does: round the object
/// by so many degrees, positive to the right, and up or down by so many. z points up, as on the stage. Where the eye is
/// nearly above or below the object, along the shortest way, in the directions of the picture.
struct Guidance {
  double right_deg = 0, up_deg = 0;
  /// As near as a hand gets.
  bool there() const;
};
Guidance guide(const Rigid3& camera_from_object, const Eigen::Vector3d& centre, const Eigen::Vector3d& next_eye);

/// "35 degrees to the left, 10 up"; "here, hold still" where it is there.
std::string in_words(const Guidance& guidance);
/// "move 35 degrees to the left, 10 up: no image from near here", as window and monitor page say it.
std::string advice_in_words(const Guidance& guidance, const std::string& reason);

}  // namespace sheen
