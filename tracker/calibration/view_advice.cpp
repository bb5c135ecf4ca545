// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/view_advice.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/angle.h"
#include "common/base/format.h"

namespace sheen {
namespace {

constexpr int kFieldColumns = 8, kFieldRows = 6;
constexpr double kEnoughTilt_deg = 15;
constexpr std::size_t kFewestViews = 5, kGoodViews = 12;
constexpr double kWorstFit_px = 3;  ///< RMS beyond which the target is not the one that was named
constexpr double kLargestFocalUncertainty = 0.01;
constexpr double kLargestUncertainty_px = 5;  ///< anywhere in the image
constexpr double kPoorUncertainty_px = 1;
constexpr double kMostRejected = 0.1;     ///< of the corners
constexpr double kHalvesDisagree = 3;     ///< times what is expected of their uncertainties
constexpr double kShapeSignificance = 4;  ///< F of the target's points taken as unknown
constexpr double kShapeGain = 0.8;        ///< and what part of the RMS is left with them at most

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

void note_coverage(const Calibration& calibration, ViewAdvice& advice) {
  constexpr const char* kNames[3][3] = {
      {"top left", "top", "top right"}, {"left", "middle", "right"}, {"bottom left", "bottom", "bottom right"}};
  std::array<std::array<bool, kFieldColumns>, kFieldRows> fields{};
  std::array<std::array<bool, 3>, 3> ninths{};
  const auto part = [](double pixel, int size, int parts) {
    return std::clamp(static_cast<int>((pixel + 0.5) / size * parts), 0, parts - 1);
  };
  for (const TargetView& view : calibration.used)
    for (const TargetSighting& s : view.sightings) {
      const auto at = [&](int columns, int rows) {
        return std::pair{part(s.pixel.y(), calibration.camera.height, rows),
                         part(s.pixel.x(), calibration.camera.width, columns)};
      };
      const auto [row, column] = at(kFieldColumns, kFieldRows);
      fields[row][column] = true;
      const auto [third_row, third_column] = at(3, 3);
      ninths[third_row][third_column] = true;
    }
  int count = 0;
  for (const auto& row : fields) count += static_cast<int>(std::count(row.begin(), row.end(), true));
  advice.covered = double(count) / (kFieldColumns * kFieldRows);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      if (!ninths[row][column]) advice.uncovered.emplace_back(kNames[row][column]);
}

void note_tilts(const Calibration& calibration, ViewAdvice& advice) {
  bool first = true;
  for (const CalibratedView& view : calibration.views) {
    if (!view.used) continue;
    Eigen::Vector3d normal = view.camera_from_target.rotation * Eigen::Vector3d::UnitZ();
    if (normal.z() < 0) normal = -normal;  // away from the camera
    // The plane is nearer where its outward normal leans to.
    const double turn = std::atan2(normal.x(), normal.z()) / kDegree,
                 nod = std::atan2(normal.y(), normal.z()) / kDegree;
    advice.least_turn_deg = first ? turn : std::min(advice.least_turn_deg, turn);
    advice.greatest_turn_deg = first ? turn : std::max(advice.greatest_turn_deg, turn);
    advice.least_nod_deg = first ? nod : std::min(advice.least_nod_deg, nod);
    advice.greatest_nod_deg = first ? nod : std::max(advice.greatest_nod_deg, nod);
    first = false;
  }
}

}  // namespace

ViewAdvice advise(const CalibrationStudy& study) {
  const Calibration& calibration = study.calibration;
  ViewAdvice advice;
  note_coverage(calibration, advice);
  note_tilts(calibration, advice);
  const auto ask_tilt = [&](double most, const char* edge) {
    if (most < kEnoughTilt_deg)
      advice.next.push_back(
          format("turn the target by 20 to 45 degrees with its %s edge nearer to the camera (so far "
                 "%.0f at most)",
                 edge, std::max(most, 0.0)));
  };
  ask_tilt(advice.greatest_turn_deg, "right");
  ask_tilt(-advice.least_turn_deg, "left");
  ask_tilt(advice.greatest_nod_deg, "lower");
  ask_tilt(-advice.least_nod_deg, "upper");
  if (study.uncertainty.worst() > kPoorUncertainty_px) {
    const Eigen::Vector2d at = study.uncertainty.worst_pixel();
    advice.next.push_back(format("bring the target to pixel (%.0f, %.0f), where the camera is uncertain by %.1f px",
                                 at.x(), at.y(), study.uncertainty.worst()));
  }
  if (!advice.uncovered.empty())
    advice.next.push_back("bring the target into the part of the image where it was never seen: " +
                          joined(advice.uncovered));
  if (calibration.used.size() < kGoodViews)
    advice.next.push_back(format("take more images: %zu are used, %zu or more make a good calibration",
                                 calibration.used.size(), kGoodViews));
  return advice;
}

std::string refusal(const CalibrationStudy& study, const ViewAdvice& advice) {
  const Calibration& calibration = study.calibration;
  std::string remedy;
  for (const std::string& sentence : advice.next) remedy += "\n  - " + sentence;
  if (!remedy.empty()) remedy = ". What is missing:" + remedy;
  if (calibration.used.size() < kFewestViews)
    return format("only %zu images can be used; a calibration needs %zu or more", calibration.used.size(),
                  kFewestViews) +
           remedy;
  if (calibration.rms_px > kWorstFit_px)
    return format(
        "the corners fit no camera: they are %.1f px off (RMS). Is the target flat, and is it the one that "
        "--target names?",
        calibration.rms_px);
  const double focal = std::sqrt(calibration.covariance(0, 0)) / calibration.camera.fx;
  if (focal > kLargestFocalUncertainty)
    return format("the focal length is uncertain by %.1f %%, more than %.0f %%", 100 * focal,
                  100 * kLargestFocalUncertainty) +
           remedy;
  if (study.uncertainty.missing() > 0)
    return std::string("the lens model ") + calibration.fit->name +
           " folds over inside the image, where no corner holds it" + remedy;
  if (study.uncertainty.worst() > kLargestUncertainty_px)
    return format("in parts of the image a pixel is uncertain by %.1f px, more than %.0f", study.uncertainty.worst(),
                  kLargestUncertainty_px) +
           remedy;
  return {};
}

std::vector<std::string> warnings(const CalibrationStudy& study) {
  std::vector<std::string> doubts;
  const Calibration& calibration = study.calibration;
  int found = 0;
  for (const CalibratedView& view : calibration.views) found += view.corners;
  const double rejected = 1 - double(calibration.corners_used()) / std::max(found, 1);
  if (rejected > kMostRejected)
    doubts.push_back(
        format("%.0f %% of the corners are outliers: blurred images, a bent target, or a lens that the "
               "model does not describe",
               100 * rejected));
  if (study.halves && study.halves->difference.rms() > kHalvesDisagree * study.halves->expected_rms_px)
    doubts.push_back(
        format("two halves of the images give cameras %.2f px apart, where noise explains %.2f: the "
               "focus changed, the target bent, or images are blurred",
               study.halves->difference.rms(), study.halves->expected_rms_px));
  if (study.shape && study.shape->significance > kShapeSignificance &&
      study.shape->rms_px < kShapeGain * calibration.rms_px)
    doubts.push_back(
        format("the target is not what it is said to be: up to %.2f mm out of its plane and %.2f mm along "
               "it; with its true shape %.3f px would be left. Glue it to glass or a stiff plate",
               1e3 * study.shape->out_of_plane_m, 1e3 * study.shape->in_plane_m, study.shape->rms_px));
  return doubts;
}

}  // namespace sheen
