// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "common/camera/camera.h"
#include "tracker/pose/reprojection.h"

namespace sheen {

struct WeightedPose {
  Rigid3 camera_from_object;
  Matrix6 covariance;  ///< of a left step (w, t)
};

/// The pose that weighs the corners of tags as they err, with its covariance. `points` holds the four corners of each
/// tag in their order; `start` is a solution already, which moves by a fraction of the corners' errors.
///
/// A refined corner is where the lines of two edges meet, so neighbouring corners share the error of an edge. The
/// errors of edges are independent. A line fitted to the points of an edge of length L errs in its place y (across, at
/// the middle) and in its tilt z (at the ends, +z and -z), independently of each other and with variances that fall
/// with the number of points:
///
///   var y = a / L,  var z = b / L        (a, b in px^2 per px of length)                                        (1)
///
/// Noise alone tilts edges more than it moves them: b = 3 a, and more where the ends are skipped. So the residuals of
/// corners are mostly tilts, of which the pose takes little notice, and their RMS overstates the errors that count.
/// Blur beside the code and the grid of pixels move edges and do not tilt them. Hence a and b are both estimated from
/// the residuals, each by its sum of squares over its degrees of freedom, which share the pose's six:
///
///   C = (A / a + B / b)^-1,  A = J_y^T J_y,  B = J_z^T J_z                   (J per sqrt(L))                    (2)
///   a = |r_y|^2 / (n - tr(C A) / a),  b = |r_z|^2 / (n - tr(C B) / b)        n edges                            (3)
///
/// A variance that is estimated with v degrees of freedom makes the pose's error one of Student's t, whose covariance
/// is larger by v / (v - 2); that is in the covariance returned. Empty where the edges do not determine a pose.
std::optional<WeightedPose> weigh_edges(const Camera& camera, std::span<const Correspondence> points,
                                        const Rigid3& start, double noise_floor_px);

}  // namespace sheen
