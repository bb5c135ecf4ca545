// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "common/stage/stage_layout.h"

namespace sheen {

/// What a stage's sheet has printed where, in the plane z = 0: tags and the blank paper round and between them. What
/// lies further out than the tags' quiet zone is not known.
class StagePicture {
 public:
  StagePicture() = default;  ///< knows nothing
  explicit StagePicture(const StageLayout& stage);

  const Eigen::AlignedBox2d& known() const { return known_; }  ///< the part of the plane that it knows
  std::size_t tags() const { return tags_; }

  /// Share of ink in a part of the plane, 0 to 1.
  float ink(const Eigen::AlignedBox2d& part) const;
  /// The number of the tag, its quiet zone included, that a known point is in; -1 in none.
  int tag_at(const Eigen::Vector2d& point) const;

 private:
  Eigen::Array2i raster_place(const Eigen::Vector2d& point) const;
  std::uint32_t& sum(int x, int y) { return sums_[x + (std::size_t(size_.x()) + 1) * y]; }
  std::uint32_t sum(int x, int y) const { return sums_[x + (std::size_t(size_.x()) + 1) * y]; }

  Eigen::AlignedBox2d known_;
  double cell_ = 1;  ///< of the raster, metres
  Eigen::Array2i size_{0, 0};
  std::size_t tags_ = 0;
  std::vector<std::uint32_t> sums_;  ///< cells of ink to the left of and above a corner of the raster
  std::vector<std::int16_t> tag_;    ///< per cell
};

}  // namespace sheen
