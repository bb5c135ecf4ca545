// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/target_finder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "tracker/fiducials/corner_refiner.h"
#include "tracker/fiducials/tag_detector.h"

namespace sheen {
namespace {

/// A corner is refined within this part of the distance to its neighbours: a larger window takes their edges in, which
/// moves corners of a target far away by a pixel.
constexpr double kWindow = 0.35;
constexpr int kLargestWindow = 8;  ///< pixels to either side

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

int refinement_window(double spacing) {
  return std::clamp(static_cast<int>(std::lround(kWindow * spacing)), 2, kLargestWindow);
}

std::vector<TargetSighting> find_chessboard(const cv::Mat& image, int columns, int rows) {
  std::vector<cv::Point2f> corners;
  const cv::Size size(columns, rows);
  if (!cv::findChessboardCornersSB(image, size, corners, cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY) &&
      !cv::findChessboardCorners(image, size, corners, cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE))
    return {};
  const int window = refinement_window(grid_spacing(corners, columns, rows));
  cv::cornerSubPix(image, corners, {window, window}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
  std::vector<TargetSighting> found;
  for (int i = 0; i < static_cast<int>(corners.size()); ++i) found.push_back({i, {corners[i].x, corners[i].y}});
  return found;
}

struct Charuco {
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  cv::Ptr<cv::aruco::CharucoBoard> board;
  cv::Ptr<cv::aruco::DetectorParameters> parameters = cv::aruco::DetectorParameters::create();
};

const std::map<std::string, int>& dictionaries() {
  static const std::map<std::string, int> all = {{"DICT_4X4_50", cv::aruco::DICT_4X4_50},
                                                 {"DICT_4X4_100", cv::aruco::DICT_4X4_100},
                                                 {"DICT_4X4_250", cv::aruco::DICT_4X4_250},
                                                 {"DICT_4X4_1000", cv::aruco::DICT_4X4_1000},
                                                 {"DICT_5X5_50", cv::aruco::DICT_5X5_50},
                                                 {"DICT_5X5_100", cv::aruco::DICT_5X5_100},
                                                 {"DICT_5X5_250", cv::aruco::DICT_5X5_250},
                                                 {"DICT_5X5_1000", cv::aruco::DICT_5X5_1000},
                                                 {"DICT_6X6_50", cv::aruco::DICT_6X6_50},
                                                 {"DICT_6X6_100", cv::aruco::DICT_6X6_100},
                                                 {"DICT_6X6_250", cv::aruco::DICT_6X6_250},
                                                 {"DICT_6X6_1000", cv::aruco::DICT_6X6_1000},
                                                 {"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL}};
  return all;
}

Charuco make_charuco(const CalibrationTarget& target) {
  const auto known = dictionaries().find(target.dictionary);
  if (known == dictionaries().end()) {
    std::string names;
    for (const auto& [name, id] : dictionaries()) names += (names.empty() ? "" : ", ") + name;
    throw ConfigError("--target: \"" + target.dictionary + "\" is no dictionary of markers; there are " + names);
  }
  Charuco charuco;
  charuco.dictionary = cv::aruco::getPredefinedDictionary(known->second);
  const int markers = target.columns * target.rows / 2;
  if (markers > charuco.dictionary->bytesList.rows)
    throw ConfigError("--target: a board of " + std::to_string(target.columns) + "x" + std::to_string(target.rows) +
                      " squares needs " + std::to_string(markers) + " markers, more than " + target.dictionary +
                      " has");
  charuco.board = cv::aruco::CharucoBoard::create(target.columns, target.rows, static_cast<float>(target.square_m),
                                                  static_cast<float>(target.marker_m), charuco.dictionary);
  return charuco;
}

/// Least distance of corners that are neighbours on the board.
double charuco_spacing(const std::vector<cv::Point2f>& corners, const std::vector<int>& ids, int columns) {
  std::map<int, cv::Point2f> known;
  for (std::size_t i = 0; i < ids.size(); ++i) known[ids[i]] = corners[i];
  double least = INFINITY;
  for (const auto& [id, corner] : known)
    for (const int step : {1, columns}) {
      if (step == 1 && (id + 1) % columns == 0) continue;
      if (const auto next = known.find(id + step); next != known.end())
        least = std::min(least, cv::norm(next->second - corner));
    }
  return std::isfinite(least) ? least : 2 / kWindow;
}

std::vector<TargetSighting> find_charuco(const cv::Mat& image, const Charuco& charuco, int columns) {
  std::vector<int> marker_ids, ids;
  std::vector<std::vector<cv::Point2f>> markers;
  cv::aruco::detectMarkers(image, charuco.dictionary, markers, marker_ids, charuco.parameters);
  if (marker_ids.empty()) return {};
  std::vector<cv::Point2f> corners;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, image, charuco.board, corners, ids);
  if (ids.size() < 4) return {};
  const int window = refinement_window(charuco_spacing(corners, ids, columns - 1));
  cv::cornerSubPix(image, corners, {window, window}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
  std::vector<TargetSighting> found;
  for (std::size_t i = 0; i < ids.size(); ++i) found.push_back({ids[i], {corners[i].x, corners[i].y}});
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
  Charuco charuco;
};

TargetFinder::TargetFinder(const CalibrationTarget& target) : impl_(std::make_unique<Impl>(Impl{target, {}})) {
  if (target.kind == TargetKind::kCharuco) impl_->charuco = make_charuco(target);
}
TargetFinder::~TargetFinder() = default;

bool TargetFinder::better_with_camera() const {
  return impl_->target.kind == TargetKind::kTags;
}

std::vector<TargetSighting> TargetFinder::find(const GreyImage& image, const Camera* camera) const {
  const CalibrationTarget& target = impl_->target;
  switch (target.kind) {
    case TargetKind::kChessboard:
      return find_chessboard(view_of(image.grey), target.columns, target.rows);
    case TargetKind::kCharuco:
      return find_charuco(view_of(image.grey), impl_->charuco, target.columns);
    case TargetKind::kTags:
      return find_tags(image, target.tags, camera);
  }
  return {};
}

}  // namespace sheen
