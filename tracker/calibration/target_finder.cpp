// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/target_finder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "tracker/calibration/charuco_finder.h"
#include "tracker/fiducials/corner_refiner.h"
#include "tracker/fiducials/tag_detector.h"

namespace sheen {
namespace {

cv::Mat view_of(const ImageU8& grey) {
  return {grey.height(), grey.width(), CV_8UC1, const_cast<std::uint8_t*>(grey.data())};
}

/// Least distance of neighbours in a grid of points row by row.
double grid_spacing(const std::vector<cv::Point2f>& corners, int columns, int rows) {
  double least = INFINITY;
  const auto at = [&](int x, int y) { return corners[y * columns + x]; };
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      if (x + 1 < columns) least = std::min(least, cv::norm(at(x + 1, y) - at(x, y)));
      if (y + 1 < rows) least = std::min(least, cv::norm(at(x, y + 1) - at(x, y)));
    }
  return least;
}

std::vector<TargetSighting> find_chessboard(const cv::Mat& image, int columns, int rows) {
  std::vector<cv::Point2f> corners;
  const cv::Size size(columns, rows);
  if (!cv::findChessboardCornersSB(image, size, corners, cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY) &&
      !cv::findChessboardCorners(image, size, corners, cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE))
    return {};
  refine_crossings(image, grid_spacing(corners, columns, rows), corners);
  std::vector<TargetSighting> found;
  for (int i = 0; i < static_cast<int>(corners.size()); ++i) found.push_back({i, {corners[i].x, corners[i].y}});
  return found;
}

std::vector<TargetSighting> find_tags(const GreyImage& image, const StageLayout& layout, const Camera* camera) {
  std::vector<TagObservation> tags = TagDetector().detect(image.grey);
  if (camera) refine_corners(image.light, *camera, tags);
  std::map<int, int> times_seen;
  for (const TagObservation& tag : tags) ++times_seen[tag.id];
  std::vector<TargetSighting> found;
  for (const TagObservation& tag : tags) {
    const StageTag* known = layout.find(tag.id);
    if (!known || times_seen[tag.id] > 1) continue;
    const int first = 4 * static_cast<int>(known - layout.tags.data());
    for (int corner = 0; corner < 4; ++corner) found.push_back({first + corner, tag.corners[corner]});
  }
  return found;
}

}  // namespace

struct TargetFinder::Impl {
  CalibrationTarget target;
  std::optional<CharucoFinder> charuco;  ///< where the target is one
};

TargetFinder::TargetFinder(const CalibrationTarget& target) : impl_(std::make_unique<Impl>()) {
  impl_->target = target;
  if (target.kind == TargetKind::kCharuco) impl_->charuco.emplace(target);
}
TargetFinder::~TargetFinder() = default;

bool TargetFinder::better_with_camera() const {
  return impl_->target.kind == TargetKind::kTags;
}

std::string TargetFinder::seen_instead() const {
  return impl_->charuco ? impl_->charuco->seen_instead() : "";
}

std::vector<TargetSighting> TargetFinder::find(const GreyImage& image, const Camera* camera) const {
  const CalibrationTarget& target = impl_->target;
  switch (target.kind) {
    case TargetKind::kChessboard:
      return find_chessboard(view_of(image.grey), target.columns, target.rows);
    case TargetKind::kCharuco:
      return impl_->charuco->find(view_of(image.grey));
    case TargetKind::kTags:
      return find_tags(image, target.tags, camera);
  }
  return {};
}

}  // namespace sheen
