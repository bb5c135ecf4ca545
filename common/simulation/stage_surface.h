// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/simulation/reflectance.h"
#include "common/stage/stage_layout.h"
#include "common/stage/tag_pattern.h"

namespace sheen {

/// The plane z = 0 of a simulated rig: the printed board on a round matt table. Beyond the table there is nothing.
class StageSurface {
 public:
  enum class Region : std::uint8_t { kNothing, kTable, kPaper, kInk };

  explicit StageSurface(const StageLayout& layout, float table_radius_m = 0.45f);

  float table_radius() const { return table_radius_; }
  /// What is printed at a point, its edges exact.
  Region region(float x, float y) const;
  /// Diffuse albedo of a region at a point.
  Eigen::Array3f albedo(Region region, float x, float y) const;

 private:
  struct PlacedTag {
    Eigen::Vector2f origin, to_column, to_row;  ///< cell coordinates are dot products with the offset from the origin
    TagPattern pattern;
  };
  static constexpr float kBin = 0.01f;  // metres

  float table_radius_;
  Eigen::Vector2f half_board_;
  std::vector<PlacedTag> tags_;
  int bins_x_ = 0, bins_y_ = 0;
  std::vector<std::vector<std::uint16_t>> bins_;  ///< tags that touch a square of the board
};

}  // namespace sheen
