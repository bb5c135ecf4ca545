// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tracker/calibration/calibration.h"
#include "tracker/calibration/projection_uncertainty.h"
#include "tracker/calibration/target.h"

namespace sheen {

/// A view of a target that a calibration would gain from.
struct WantedView {
  Rigid3 camera_from_target;
  double uncertainty_left = 1;  ///< of the projection (RMS over the image) with it, over that without
  std::string in_words;         ///< what a person does
};

/// What one more view of a target would make of a calibration, before it is taken: the information of its corners is
/// added with its pose marginalised, the camera is not estimated again.
class NextViews {
 public:
  /// Both must outlive it.
  NextViews(const Calibration& calibration, const CalibrationTarget& target);

  /// RMS over the image of the uncertainty of a pixel with this view, over that without.
  double uncertainty_left(const TargetView& view, const Rigid3& camera_from_target) const;
  /// The best of 90: the target in each ninth of the image, in two sizes, facing the camera or tilted to one of four
  /// sides.
  WantedView best() const;

 private:
  /// Of the numbers that the model estimates, 1/px^2 at a noise of 1 px.
  Eigen::MatrixXd information_of(const TargetView& view, const Rigid3& camera_from_target) const;
  TargetView seen_from(const Rigid3& camera_from_target) const;
  double rms_with(const Eigen::MatrixXd& information) const;

  const Calibration& calibration_;
  const CalibrationTarget& target_;
  std::vector<int> free_;  ///< which of `Intrinsics` those are
  Eigen::MatrixXd information_;
  double rms_ = 0;
};

}  // namespace sheen
