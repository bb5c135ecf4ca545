// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tracker/calibration/calibration.h"
#include "tracker/calibration/projection_uncertainty.h"
#include "tracker/calibration/target_shape.h"

namespace sheen {

/// One lens model on the same sightings as the others.
struct LensComparison {
  const LensFit* fit = nullptr;
  double rms_px = 0;
  /// RMS over views that the camera was not estimated from (five parts, each left out once); their poses are solved.
  double cross_validated_px = 0;
  std::string failure;  ///< why it could not be estimated; empty: it could
  bool folds = false;   ///< somewhere in the image the model has no ray: it cannot be used
};

/// Two cameras, each from every other view, and how far they are apart. Where the errors of the views are independent,
/// the RMS of the difference is near what is expected of their uncertainties. It is blind to what is wrong in all views
/// alike: that is `TargetShape`'s and the comparison of models.
struct HalvesComparison {
  ImageMap difference;
  double expected_rms_px = 0;
};

struct CalibrationStudy {
  Calibration calibration;
  std::vector<LensComparison> lenses;
  ImageMap uncertainty;
  std::optional<HalvesComparison> halves;  ///< empty with too few views
  std::optional<TargetShape> shape;        ///< empty where the views do not tell it
};

/// Told how many of its steps are done; what it throws ends the study.
using StudyProgress = std::function<void(int done, int steps)>;

/// Calibrates with `fit`; null: with the model of fewest numbers whose cross-validated error is no worse than the best
/// one's, by more than two standard errors of the difference. Compares all models, and halves of the views. Throws
/// Error as `calibrate` does.
CalibrationStudy study_calibration(std::span<const Eigen::Vector3d> target, std::span<const TargetView> views,
                                   ImageSize size, const LensFit* fit, const StudyProgress& progress = {});

}  // namespace sheen
