// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/evaluation/error_calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace sheen {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

CalibratedPsnr ErrorCalibration::apply(double predicted_db) const {
  if (!known()) return {kNaN, kNaN, kNaN};
  const double db = predicted_db + offset_db;
  return {db, db - half_width_db, db + half_width_db};
}

ErrorCalibration calibrate(std::span<const double> differences_db) {
  std::vector<double> sorted;
  for (const double difference : differences_db)
    if (std::isfinite(difference)) sorted.push_back(difference);
  const std::size_t n = sorted.size();
  ErrorCalibration calibration{.views = n};
  if (!calibration.known()) return calibration;
  std::sort(sorted.begin(), sorted.end());  // the same bits in any order of the views
  const auto count = static_cast<double>(n);
  calibration.offset_db = std::accumulate(sorted.begin(), sorted.end(), 0.0) / count;
  std::vector<double> off;
  for (const double difference : sorted)
    off.push_back(std::abs(difference - calibration.offset_db) * count / (count - 1));
  std::sort(off.begin(), off.end());
  constexpr double kRounding = 1e-9;  // 0.8 * 5 views is 4 of them
  const double rank = std::ceil(ErrorCalibration::kCoverage * (count + 1) - kRounding);
  calibration.half_width_db = off[static_cast<std::size_t>(rank) - 1];
  return calibration;
}

std::vector<ErrorCalibration> calibrate_by_the_others(std::span<const double> differences_db) {
  std::vector<ErrorCalibration> calibrations;
  for (std::size_t i = 0; i < differences_db.size(); ++i) {
    std::vector<double> others(differences_db.begin(), differences_db.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    calibrations.push_back(calibrate(others));
  }
  return calibrations;
}

CalibrationCheck check_calibration(std::span<const double> predicted_db, std::span<const double> measured_db) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < predicted_db.size(); ++i) differences.push_back(measured_db[i] - predicted_db[i]);
  const std::vector<ErrorCalibration> by_the_others = calibrate_by_the_others(differences);
  CalibrationCheck check;
  for (std::size_t i = 0; i < differences.size(); ++i)
    if (std::isfinite(differences[i])) check.views.push_back({i, predicted_db[i], by_the_others[i], measured_db[i]});
  const auto mean = [&](const auto& of_view) {
    double sum = 0;
    for (const PredictedView& view : check.views) sum += of_view(view);
    return check.views.empty() ? kNaN : sum / static_cast<double>(check.views.size());
  };
  check.predicted_db = mean([](const PredictedView& view) { return view.predicted_db; });
  check.measured_db = mean([](const PredictedView& view) { return view.measured_db; });
  check.calibrated_db = mean([](const PredictedView& view) { return view.calibrated().db; });
  check.coverage = check.known() ? mean([](const PredictedView& view) { return view.inside() ? 1.0 : 0.0; }) : kNaN;
  return check;
}

}  // namespace sheen
