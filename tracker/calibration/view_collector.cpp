// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/view_collector.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/base/errors.h"
#include "tracker/calibration/next_view.h"
#include "tracker/calibration/view_advice.h"
#include "tracker/pose/pose_solver.h"

namespace sheen {
namespace {

constexpr std::size_t kFewestCorners = 6;  ///< of a view, and of two that are compared
constexpr std::size_t kFirstViews = 5;     ///< before a camera is estimated
constexpr double kHuber_px = 1;
constexpr double kWorthwhileLeft = 0.9;  ///< of the uncertainty, with a view that a person is asked for by its place
constexpr const char* kBegin = "show the target, all of it, and hold it still";
constexpr const char* kTilt = "tilt the target by 20 to 45 degrees, to another side each time";

/// RMS distance of the corners that both show, pixels; nothing where they are few.
std::optional<double> moved(const TargetView& from, const TargetView& to) {
  std::map<int, Eigen::Vector2d> before;
  for (const TargetSighting& s : from.sightings) before[s.point] = s.pixel;
  double sum = 0;
  std::size_t common = 0;
  for (const TargetSighting& s : to.sightings) {
    const auto found = before.find(s.point);
    if (found == before.end()) continue;
    sum += (s.pixel - found->second).squaredNorm();
    ++common;
  }
  if (common < kFewestCorners) return {};
  return std::sqrt(sum / static_cast<double>(common));
}

/// RMS distance of the corners from their middle, pixels.
double size_of(const TargetView& view) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0;
  for (const TargetSighting& s : view.sightings) {
    sum += s.pixel;
    squares += s.pixel.squaredNorm();
  }
  const auto n = static_cast<double>(view.sightings.size());
  return std::sqrt(std::max(0.0, squares / n - (sum / n).squaredNorm()));
}

}  // namespace

ViewCollector::ViewCollector(CalibrationTarget target, ImageSize size, const LensFit& fit,
                             const ViewCollectorOptions& options)
    : target_(std::move(target)), finder_(target_), size_(size), fit_(fit), options_(options), next_view_(kBegin) {}

SeenView ViewCollector::see(const GreyImage& image, double at_s, double exposure_s) {
  return see({std::to_string(views_.size() + 1), finder_.find(image)}, at_s, exposure_s);
}

SeenView ViewCollector::see(TargetView view, double at_s, double exposure_s) {
  if (view.sightings.size() < kFewestCorners) return SeenView::kNoTarget;
  const bool is_still = still(view, at_s, exposure_s);
  last_ = view;
  last_at_s_ = at_s;
  if (!is_still) return SeenView::kMoving;
  if (views_.size() >= options_.most_views || !adds(view)) return SeenView::kNothingNew;
  views_.push_back(std::move(view));
  estimate();
  return SeenView::kKept;
}

bool ViewCollector::still(const TargetView& view, double at_s, double exposure_s) const {
  const std::optional<double> by = moved(last_, view);
  if (!by) return false;
  const double seconds = at_s - last_at_s_;
  const bool sharp = exposure_s > 0 && seconds > 0 && *by * exposure_s / seconds <= options_.most_blur_px;
  return sharp || *by <= options_.most_moved_px;
}

bool ViewCollector::adds(const TargetView& view) const {
  if (!study_)
    return std::none_of(views_.begin(), views_.end(), [&](const TargetView& other) {
      const std::optional<double> by = moved(other, view);
      return by && *by < options_.least_change * size_of(view);
    });
  std::vector<Correspondence> points;
  for (const TargetSighting& s : view.sightings) points.push_back({target_.points[s.point], s.pixel});
  const auto pose = solve_pose_of_points(study_->calibration.camera, points, kHuber_px);
  return pose &&
         NextViews(study_->calibration, target_).uncertainty_left(view, pose->camera_from_object) <= options_.most_left;
}

void ViewCollector::estimate() {
  next_view_ = kTilt;
  if (views_.size() < kFirstViews) return;
  try {
    CalibrationStudy study{.calibration = calibrate(target_.points, views_, size_, fit_)};
    study.uncertainty = projection_uncertainty(study.calibration.camera, study.calibration.covariance);
    study_ = std::move(study);
  } catch (const Error&) {  // they do not determine a camera yet
    return;
  }
  const std::vector<std::string> missing = advise(*study_).next;
  const WantedView best = NextViews(study_->calibration, target_).best();
  const bool worthwhile = best.uncertainty_left <= kWorthwhileLeft;
  complete_ = missing.empty() && !worthwhile;
  if (worthwhile)
    next_view_ = best.in_words;
  else
    next_view_ = complete_ ? "" : missing.front();
}

}  // namespace sheen
