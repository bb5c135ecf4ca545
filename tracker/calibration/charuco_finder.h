// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tracker/calibration/target.h"

namespace cv {
class Mat;
template <typename T>
class Point_;
}  // namespace cv

namespace sheen {

/// Refines corners (pixels) at which two black and two white squares meet. `spacing_px`: to the nearest other corner.
void refine_crossings(const cv::Mat& image, double spacing_px, std::vector<cv::Point_<float>>& corners);

/// Finds the corners of a ChArUco board. Boards with an even number of rows have a white square at the upper left where
/// they were made before OpenCV 4.6, and a black one since: where the markers lie says which it is.
class CharucoFinder {
 public:
  /// Throws ConfigError for a dictionary that there is not, or that has too few markers.
  explicit CharucoFinder(const CalibrationTarget& target);
  ~CharucoFinder();

  /// `image`: 8-bit grey. Corners between two or more markers that are found.
  std::vector<TargetSighting> find(const cv::Mat& image) const;
  /// What `find` saw instead of the board: its markers in other places. A sentence for a person; empty: nothing.
  std::string seen_instead() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
