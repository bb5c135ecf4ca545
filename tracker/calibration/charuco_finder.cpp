// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/charuco_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "common/base/errors.h"
#include "common/base/format.h"

namespace sheen {
namespace {

/// A corner is refined within this part of the distance to its neighbours: a larger window takes their edges in, which
/// moves corners of a target far away by a pixel.
constexpr double kWindow = 0.35;
constexpr int kLargestWindow = 8;   ///< pixels to either side
constexpr double kAgreement = 0.4;  ///< of a square: how far off a marker's neighbour may be from where it says

using Corners = std::vector<cv::Point2f>;

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

cv::Ptr<cv::aruco::Dictionary> dictionary_of(const CalibrationTarget& target) {
  const auto known = dictionaries().find(target.dictionary);
  if (known == dictionaries().end()) {
    std::string names;
    for (const auto& [name, id] : dictionaries()) names += (names.empty() ? "" : ", ") + name;
    throw ConfigError("--target: \"" + target.dictionary + "\" is no dictionary of markers; there are " + names);
  }
  cv::Ptr<cv::aruco::Dictionary> dictionary = cv::aruco::getPredefinedDictionary(known->second);
  const int markers = target.columns * target.rows / 2;
  if (markers > dictionary->bytesList.rows)
    throw ConfigError("--target: a board of " + std::to_string(target.columns) + "x" + std::to_string(target.rows) +
                      " squares needs " + std::to_string(markers) + " markers, more than " + target.dictionary +
                      " has");
  return dictionary;
}

/// Where the markers of a board lie. They are numbered row by row from the upper left, in white squares only.
struct Layout {
  int columns = 0, rows = 0;
  bool begins_white = false;                 ///< the square at the upper left
  std::vector<std::pair<int, int>> squares;  ///< column and row of each marker

  Layout(int columns, int rows, bool begins_white) : columns(columns), rows(rows), begins_white(begins_white) {
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column)
        if (((row + column) % 2 == 0) == begins_white) squares.emplace_back(column, row);
  }
};

/// The layout as OpenCV's board: what `create` makes, with the markers in their places and the corners beside them.
cv::Ptr<cv::aruco::CharucoBoard> board_of(const CalibrationTarget& target, const Layout& layout,
                                          const cv::Ptr<cv::aruco::Dictionary>& dictionary) {
  const float square = static_cast<float>(target.square_m), marker = static_cast<float>(target.marker_m);
  const auto board = cv::aruco::CharucoBoard::create(layout.columns, layout.rows, square, marker, dictionary);
  board->ids.clear();
  board->objPoints.clear();
  std::map<std::pair<int, int>, int> marker_in;
  for (const auto& [column, row] : layout.squares) {
    const float x = float(column) * square + (square - marker) / 2, y = float(row) * square + (square - marker) / 2;
    marker_in[{column, row}] = static_cast<int>(board->ids.size());
    board->ids.push_back(static_cast<int>(board->ids.size()));
    board->objPoints.push_back({{x, y, 0}, {x + marker, y, 0}, {x + marker, y + marker, 0}, {x, y + marker, 0}});
  }
  board->chessboardCorners.clear();
  board->nearestMarkerIdx.clear();
  board->nearestMarkerCorners.clear();
  for (int row = 1; row < layout.rows; ++row)
    for (int column = 1; column < layout.columns; ++column) {
      board->chessboardCorners.emplace_back(float(column) * square, float(row) * square, 0.f);
      std::vector<int> markers, nearest;
      // The four squares round the corner, each with the marker's corner that points to it.
      for (const auto& [dx, dy, corner] : {std::array{-1, -1, 2}, {0, -1, 3}, {-1, 0, 1}, {0, 0, 0}})
        if (const auto found = marker_in.find({column + dx, row + dy}); found != marker_in.end()) {
          markers.push_back(found->second);
          nearest.push_back(corner);
        }
      board->nearestMarkerIdx.push_back(std::move(markers));
      board->nearestMarkerCorners.push_back(std::move(nearest));
    }
  return board;
}

/// Least distance of corners that are neighbours on the board.
double spacing_of(const Corners& corners, const std::vector<int>& ids, int columns) {
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

/// Pairs of markers in squares that touch, and how many of them lie beside each other in the image as well.
struct Agreement {
  int pairs = 0, agree = 0;
  bool holds() const { return agree > 0 && 2 * agree >= pairs; }
};

/// `side`: of a marker, in squares. A marker says where its neighbours are: so near that a lens's distortion is none.
Agreement agreement(const Layout& layout, float side, const std::vector<int>& ids,
                    const std::vector<Corners>& markers) {
  const float edge = (1 - side) / 2;
  const Corners square = {{edge, edge}, {1 - edge, edge}, {1 - edge, 1 - edge}, {edge, 1 - edge}};
  Agreement result;
  for (std::size_t a = 0; a < ids.size(); ++a) {
    if (ids[a] >= static_cast<int>(layout.squares.size())) continue;
    const cv::Mat from_image = cv::getPerspectiveTransform(markers[a], square);
    for (std::size_t b = 0; b < ids.size(); ++b) {
      if (ids[b] >= static_cast<int>(layout.squares.size())) continue;
      const cv::Point2f step(float(layout.squares[ids[b]].first - layout.squares[ids[a]].first),
                             float(layout.squares[ids[b]].second - layout.squares[ids[a]].second));
      if (std::abs(step.x) != 1 || std::abs(step.y) != 1) continue;
      Corners there;
      cv::perspectiveTransform(markers[b], there, from_image);
      const cv::Point2f centre = (there[0] + there[1] + there[2] + there[3]) / 4.f;
      ++result.pairs;
      result.agree += cv::norm(centre - step - cv::Point2f(0.5f, 0.5f)) < kAgreement;
    }
  }
  return result;
}

std::string size_text(int columns, int rows) {
  return std::to_string(columns) + "x" + std::to_string(rows);
}

}  // namespace

void refine_crossings(const cv::Mat& image, double spacing_px, Corners& corners) {
  const int window = std::clamp(static_cast<int>(std::lround(kWindow * spacing_px)), 2, kLargestWindow);
  cv::cornerSubPix(image, corners, {window, window}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
}

struct CharucoFinder::Impl {
  CalibrationTarget target;
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  struct Board {
    Layout layout;
    cv::Ptr<cv::aruco::CharucoBoard> board;
  };
  std::vector<Board> boards;
  cv::Ptr<cv::aruco::DetectorParameters> parameters = cv::aruco::DetectorParameters::create();
  std::string seen_instead;

  const Board* board_seen(const std::vector<int>& ids, const std::vector<Corners>& markers);
};

CharucoFinder::CharucoFinder(const CalibrationTarget& target) : impl_(std::make_unique<Impl>()) {
  impl_->target = target;
  impl_->dictionary = dictionary_of(target);
  for (const bool begins_white : {false, true}) {
    const Layout layout(target.columns, target.rows, begins_white);
    if (static_cast<int>(layout.squares.size()) > impl_->dictionary->bytesList.rows) continue;
    impl_->boards.push_back({layout, board_of(target, layout, impl_->dictionary)});
  }
}
CharucoFinder::~CharucoFinder() = default;

/// The board whose neighbours are neighbours in the image; null: neither, and `seen_instead` says so.
const CharucoFinder::Impl::Board* CharucoFinder::Impl::board_seen(const std::vector<int>& ids,
                                                                  const std::vector<Corners>& markers) {
  const auto side = static_cast<float>(target.marker_m / target.square_m);
  const Board* best = nullptr;
  int agree = 0, pairs = 0;
  for (const Board& board : boards) {
    const Agreement found = agreement(board.layout, side, ids, markers);
    pairs += found.pairs;
    if (!found.holds() || found.agree <= agree) continue;
    agree = found.agree;
    best = &board;
  }
  if (best || pairs == 0) return best;
  const std::string given = size_text(target.columns, target.rows), swapped = size_text(target.rows, target.columns);
  seen_instead =
      "markers of " + target.dictionary + " are in the images, but not where a board of " + given + " squares has them";
  const bool lies_across = agreement(Layout(target.rows, target.columns, false), side, ids, markers).holds() ||
                           agreement(Layout(target.rows, target.columns, true), side, ids, markers).holds();
  if (lies_across)
    seen_instead += ": they lie as on one of " + swapped + ". Columns come first: --target charuco:" + swapped + ":...";
  return nullptr;
}

std::vector<TargetSighting> CharucoFinder::find(const cv::Mat& image) const {
  std::vector<int> marker_ids, ids;
  std::vector<Corners> markers;
  cv::aruco::detectMarkers(image, impl_->dictionary, markers, marker_ids, impl_->parameters);
  const Impl::Board* const seen = impl_->board_seen(marker_ids, markers);
  if (!seen) return {};
  Corners corners;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, image, seen->board, corners, ids);
  if (ids.size() < 4) return {};
  refine_crossings(image, spacing_of(corners, ids, impl_->target.columns - 1), corners);
  std::vector<TargetSighting> found;
  for (std::size_t i = 0; i < ids.size(); ++i) found.push_back({ids[i], {corners[i].x, corners[i].y}});
  return found;
}

std::string CharucoFinder::seen_instead() const {
  return impl_->seen_instead;
}

}  // namespace sheen
