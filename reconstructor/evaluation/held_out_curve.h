// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/capture/held_out_point.h"
#include "reconstructor/evaluation/held_out.h"

namespace sheen {

/// Views by which a growing model is judged again and again: of the held-out ones, in the order in which they came,
/// those at least 25 degrees from each other as seen from `centre`, at most four, and at most four million pixels where
/// that leaves one. Views that come later never push one out. Indices.
std::vector<std::size_t> judging_panel(const std::vector<HeldOutView>& held_out, const Eigen::Vector3d& centre);

/// What a growing model scores on views that it never saw, the same ones at every point: when other views judge, the
/// curve begins again. Of a long capture every second of the older points goes, as often as need be.
class HeldOutCurve {
 public:
  static constexpr std::size_t kMostPoints = 200;

  /// `panel`: indices of `held_out`, not empty.
  void judge(const std::vector<HeldOutView>& held_out, const std::vector<std::size_t>& panel, std::uint64_t images,
             const Appearance& model, const Appearance& constant, const RayPainter& painter);
  void add(const HeldOutPoint& point);
  const std::vector<HeldOutPoint>& points() const { return points_; }

 private:
  std::vector<std::pair<std::string, std::uint64_t>> panel_;  ///< source session and sequence
  std::vector<HeldOutPoint> points_;
};

}  // namespace sheen
