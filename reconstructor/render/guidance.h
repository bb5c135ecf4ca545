// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "common/camera/rigid3.h"

namespace sheen {

/// How to move from one eye to another by the shortest way over a sphere round the centre, as the person who holds the
/// camera sees it: degrees along the way's first direction, positive to the right and up. Over the top is "up".
struct Guidance {
  double right_deg = 0, up_deg = 0;
  /// As near as a hand gets.
  bool there() const;
};
Guidance guide(const Rigid3& camera_from_object, const Eigen::Vector3d& centre, const Eigen::Vector3d& next_eye);

/// "35 degrees to the left, 10 up"; "here, hold still" where it is there.
std::string in_words(const Guidance& guidance);

}  // namespace sheen
