// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace sheen {

/// A predicted PSNR after calibration, and the interval that is to hold `ErrorCalibration::kCoverage` of the views.
struct CalibratedPsnr {
  double db = 0, low_db = 0, high_db = 0;
};

/// By how much the PSNR that a model predicts of a view is wrong: conformal prediction (Vovk et al. 2005) on views that
/// the model never saw. It is right for views to come as far as these are spread like the held-out ones.
struct ErrorCalibration {
  static constexpr double kCoverage = 0.8;
  static constexpr std::size_t kFewestViews = 4;  ///< fewer have no order statistic that holds 80 % of the next view

  std::size_t views = 0;     ///< held-out views that it rests on
  double offset_db = 0;      ///< measured less predicted PSNR: mean over the views
  double half_width_db = 0;  ///< of the interval round the calibrated prediction

  /// When it does not, no figure stands for it: a prediction is "not calibrated".
  bool known() const { return views >= kFewestViews; }
  CalibratedPsnr apply(double predicted_db) const;
};

/// From measured less predicted PSNR, a held-out view each; those that are not finite do not count. The half width is
/// the conformal order statistic, of rank ceil(0.8 (n + 1)), of how far each view is off the mean of the others
/// (jackknife).
ErrorCalibration calibrate(std::span<const double> differences_db);

/// For each view the calibration by all others: so that what a view was is not in what is said of it.
std::vector<ErrorCalibration> calibrate_by_the_others(std::span<const double> differences_db);

/// A view that the model never saw, dB inside the object's edge.
struct PredictedView {
  std::size_t index = 0;  ///< of the list that it comes from
  double predicted_db = 0;
  ErrorCalibration by_the_others;
  double measured_db = 0;

  CalibratedPsnr calibrated() const { return by_the_others.apply(predicted_db); }
  bool inside() const { return calibrated().low_db <= measured_db && measured_db <= calibrated().high_db; }
};

/// The held-out views that have both figures, each calibrated by the others. The means are over all of them; NaN where
/// there are none, or fewer than calibrate.
struct CalibrationCheck {
  std::vector<PredictedView> views;
  double predicted_db = 0, calibrated_db = 0, measured_db = 0;
  double coverage = 0;  ///< fraction of the views inside their intervals
  bool known() const { return views.size() > ErrorCalibration::kFewestViews; }
};
CalibrationCheck check_calibration(std::span<const double> predicted_db, std::span<const double> measured_db);

}  // namespace sheen
