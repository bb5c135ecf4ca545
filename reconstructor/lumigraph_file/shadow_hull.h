// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "reconstructor/lumigraph_file/light_set.h"

namespace sheen {

/// The space that can hide a lamp, where no mesh is known: cells that neither a camera looks through (its depth map
/// lies behind them) nor the light of any lamp passes through. The more of a lamp's ways through a cell end at pixels
/// that are seen to be lit, the less solid it is; between the cells' centres solidity is interpolated. What is left
/// holds all that casts the shadows of all captured lights together, and so the shadows of the lights between.
class ShadowHull {
 public:
  static constexpr std::uint8_t kSolid = 15;  ///< of a cell through which no light is seen to pass
  static constexpr int kMostCellsOnASide = 1 << 14;

  ShadowHull() = default;
  /// `origin`: corner of the first cell; `cell`: metres along a side; `cells`: solidity, 0 to `kSolid`, x fastest.
  ShadowHull(const Eigen::Vector3f& origin, float cell, const Eigen::Vector3i& size, std::vector<std::uint8_t> cells)
      : origin_(origin), cell_(cell), size_(size), cells_(std::move(cells)) {}

  /// Whether something on the way from a point to a lamp is solid, but for what belongs to the point's surface.
  bool hides(const Eigen::Vector3f& point, const Lamp& lamp) const;

  bool empty() const { return cells_.empty(); }
  const Eigen::Vector3f& origin() const { return origin_; }
  float cell() const { return cell_; }
  const Eigen::Vector3i& size() const { return size_; }
  const std::vector<std::uint8_t>& cells() const { return cells_; }

 private:
  /// Interpolated between the centres of cells; negative outside.
  float solidity(const Eigen::Vector3f& place) const;

  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  float cell_ = 0;
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  std::vector<std::uint8_t> cells_;
};

/// Cells: a way to a lamp begins that far off its point, which is not asked.
inline constexpr float kHullClearance = 5.5f;

}  // namespace sheen
