// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "common/stage/stage_layout.h"

namespace sheen {

enum class TargetKind : std::uint8_t { kChessboard, kCharuco, kTags };

/// A flat pattern whose points are known: what a camera is calibrated from.
struct CalibrationTarget {
  TargetKind kind = TargetKind::kChessboard;
  int columns = 0, rows = 0;  ///< inner corners of a chessboard; squares of a ChArUco board
  double square_m = 0, marker_m = 0;
  std::string dictionary;               ///< of ChArUco markers, as OpenCV calls it
  StageLayout tags;                     ///< of kTags: points are their corners, four a tag in the layout's order
  std::vector<Eigen::Vector3d> points;  ///< metres

  /// What a person reads of a point: "corner 12", "tag 5 corner 2".
  std::string point_name(int point) const;
};

struct TargetSighting {
  int point = 0;  ///< of `CalibrationTarget::points`
  Eigen::Vector2d pixel;
};

/// What `--target` takes, for messages and `--help`.
inline constexpr const char* kTargetSyntax =
    "chessboard:9x6:25mm (inner corners, side of a square), charuco:7x5:30mm:22mm[:DICT_4X4_250] (squares, side of a "
    "square, of a marker), aprilgrid:6x6:24mm:0.3 (tags, side of a tag, gap as a part of it; upright tag36h11 from 0 "
    "at the "
    "lower left) or stage:STAGE.json (the sheet that `sheen-tracker stage` makes)";

/// Throws ConfigError, and FileError for a stage that cannot be read.
CalibrationTarget parse_target(const std::string& text);

}  // namespace sheen
