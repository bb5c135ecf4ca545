// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/calibration_study.h"

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "tracker/pose/pose_solver.h"

namespace sheen {
namespace {

constexpr std::size_t kParts = 5;          ///< of the cross-validation
constexpr std::size_t kFewestPerHalf = 4;  ///< views
constexpr double kHuberPx = 1;
/// What the outliers are judged by: rich enough for ordinary lenses.
constexpr const char* kJudge = "brown-k3";

std::vector<TargetView> part_of(std::span<const TargetView> views, const std::function<bool(std::size_t)>& belongs) {
  std::vector<TargetView> part;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (belongs(i)) part.push_back(views[i]);
  return part;
}

/// Mean squared error of a view's corners under its best pose.
double view_error(const Camera& camera, std::span<const Eigen::Vector3d> target, const TargetView& view) {
  std::vector<Correspondence> points;
  for (const TargetSighting& s : view.sightings) points.push_back({target[s.point], s.pixel});
  const auto pose = solve_pose_of_points(camera, points, kHuberPx);
  double sum = 0;
  for (const Correspondence& point : points) {
    const auto pixel = pose ? camera.project(pose->camera_from_object * point.point_object) : std::nullopt;
    if (!pixel) return INFINITY;
    sum += (*pixel - point.pixel).squaredNorm();
  }
  return sum / static_cast<double>(points.size());
}

/// Mean squared error of each view under the camera of the views of the other parts.
std::vector<double> cross_validate(std::span<const Eigen::Vector3d> target, std::span<const TargetView> views,
                                   const Camera& start, const LensFit& fit) {
  std::vector<double> errors(views.size(), INFINITY);
  const std::size_t parts = std::min(kParts, views.size());
  for (std::size_t part = 0; part < parts; ++part) {
    const auto others = part_of(views, [&](std::size_t i) { return i % parts != part; });
    const Camera camera = recalibrate(target, others, start, fit).camera;
    for (std::size_t i = part; i < views.size(); i += parts) errors[i] = view_error(camera, target, views[i]);
  }
  return errors;
}

double mean(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Whether `errors` are larger than `best` by more than two standard errors of their mean difference.
bool clearly_worse(std::span<const double> errors, std::span<const double> best) {
  const double count = static_cast<double>(errors.size()), difference = mean(errors) - mean(best);
  double spread = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) spread += std::pow(errors[i] - best[i] - difference, 2);
  return difference > 2 * std::sqrt(spread / (count - 1) / count);
}

bool folds_in_image(const Camera& camera) {
  return projection_difference(camera, camera).missing() > 0;
}

struct Compared {
  LensComparison comparison;
  std::vector<double> view_errors;
};

Compared compare(std::span<const Eigen::Vector3d> target, std::span<const TargetView> views, const Camera& start,
                 const LensFit& fit) {
  Compared result{.comparison = {.fit = &fit}};
  try {
    const Calibration calibration = recalibrate(target, views, start, fit);
    result.comparison.rms_px = calibration.rms_px;
    result.comparison.folds = folds_in_image(calibration.camera);
    result.view_errors = cross_validate(target, views, calibration.camera, fit);
    result.comparison.cross_validated_px = std::sqrt(mean(result.view_errors));
  } catch (const Error& error) {
    result.comparison.failure = error.what();
  }
  return result;
}

bool eligible(const Compared& compared) {
  return compared.comparison.failure.empty() && !compared.comparison.folds &&
         std::isfinite(compared.comparison.cross_validated_px);
}

const LensFit* choose(std::span<const Compared> all) {
  const Compared* best = nullptr;
  for (const Compared& one : all)
    if (eligible(one) && (!best || one.comparison.cross_validated_px < best->comparison.cross_validated_px))
      best = &one;
  if (!best) return nullptr;
  const Compared* chosen = best;
  for (const Compared& one : all)
    if (eligible(one) && !clearly_worse(one.view_errors, best->view_errors) &&
        one.comparison.fit->parameters() < chosen->comparison.fit->parameters())
      chosen = &one;
  return chosen->comparison.fit;
}

std::optional<HalvesComparison> compare_halves(std::span<const Eigen::Vector3d> target, const Calibration& whole) {
  if (whole.used.size() < 2 * kFewestPerHalf) return std::nullopt;
  Calibration halves[2];
  for (std::size_t half = 0; half < 2; ++half) {
    const auto views = part_of(whole.used, [&](std::size_t i) { return i % 2 == half; });
    try {
      halves[half] = recalibrate(target, views, whole.camera, *whole.fit);
    } catch (const Error&) {
      return std::nullopt;  // half the views do not determine a camera; the whole does
    }
  }
  HalvesComparison result{.difference = projection_difference(halves[0].camera, halves[1].camera)};
  const double a = projection_uncertainty(whole.camera, halves[0].covariance).rms();
  const double b = projection_uncertainty(whole.camera, halves[1].covariance).rms();
  result.expected_rms_px = std::hypot(a, b);
  return result;
}

std::optional<TargetShape> shape_of(std::span<const Eigen::Vector3d> target, const Calibration& calibration) {
  if (calibration.used.size() < kFewestPerHalf) return std::nullopt;
  try {
    return estimate_target_shape(target, calibration);
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

CalibrationStudy study_calibration(std::span<const Eigen::Vector3d> target, std::span<const TargetView> views,
                                   ImageSize size, const LensFit* fit, const StudyProgress& progress) {
  const int steps = static_cast<int>(lens_fits().size()) + 2;
  int done = 0;
  const auto step = [&] {
    if (progress) progress(++done, steps);
  };
  const Calibration judged = calibrate(target, views, size, fit ? *fit : *find_lens_fit(kJudge));
  step();
  std::vector<Compared> compared;
  for (const LensFit& one : lens_fits()) {
    compared.push_back(compare(target, judged.used, judged.camera, one));
    step();
  }
  CalibrationStudy study;
  const LensFit* chosen = fit ? fit : choose(compared);
  study.calibration = !chosen || chosen == judged.fit ? judged : calibrate(target, views, size, *chosen);
  for (const Compared& one : compared) study.lenses.push_back(one.comparison);
  study.uncertainty = projection_uncertainty(study.calibration.camera, study.calibration.covariance);
  study.halves = compare_halves(target, study.calibration);
  study.shape = shape_of(target, study.calibration);
  step();
  return study;
}

}  // namespace sheen
