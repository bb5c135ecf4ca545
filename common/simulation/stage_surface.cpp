// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/stage_surface.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/simulation/procedural_noise.h"

namespace sheen {
namespace {

const Eigen::Array3f kPaperAlbedo(0.46f, 0.46f, 0.45f);
const Eigen::Array3f kInkAlbedo(0.035f, 0.035f, 0.037f);
const Eigen::Array3f kTableAlbedo(0.17f, 0.115f, 0.08f);

}  // namespace

StageSurface::StageSurface(const StageLayout& layout, float table_radius_m)
    : table_radius_(table_radius_m),
      half_board_(static_cast<float>(layout.width_m / 2), static_cast<float>(layout.height_m / 2)),
      bins_x_(static_cast<int>(std::ceil(layout.width_m / kBin))),
      bins_y_(static_cast<int>(std::ceil(layout.height_m / kBin))),
      bins_(std::size_t(bins_x_) * bins_y_) {
  for (const StageTag& tag : layout.tags) {
    const Eigen::Vector2f top_left = tag.corners_object[0].head<2>().cast<float>();
    const Eigen::Vector2f right = tag.corners_object[1].head<2>().cast<float>() - top_left;
    const Eigen::Vector2f down = tag.corners_object[3].head<2>().cast<float>() - top_left;
    Eigen::Matrix2f tag_axes;
    tag_axes << right, down;
    const Eigen::Matrix2f cells_from_offset = kTagCells * tag_axes.inverse();
    tags_.push_back({top_left, cells_from_offset.row(0), cells_from_offset.row(1), tag_pattern(tag.id)});
    Eigen::Array2f low = top_left, high = top_left;
    for (const Eigen::Vector3d& corner : tag.corners_object) {
      low = low.min(corner.head<2>().cast<float>().array());
      high = high.max(corner.head<2>().cast<float>().array());
    }
    const Eigen::Array2i first = ((low + half_board_.array()) / kBin).floor().cast<int>().max(0);
    const Eigen::Array2i last =
        ((high + half_board_.array()) / kBin).floor().cast<int>().min(Eigen::Array2i(bins_x_ - 1, bins_y_ - 1));
    for (int y = first.y(); y <= last.y(); ++y)
      for (int x = first.x(); x <= last.x(); ++x)
        bins_[std::size_t(y) * bins_x_ + x].push_back(static_cast<std::uint16_t>(tags_.size() - 1));
  }
}

StageSurface::Region StageSurface::region(float x, float y) const {
  if (std::abs(x) >= half_board_.x() || std::abs(y) >= half_board_.y())
    return x * x + y * y < table_radius_ * table_radius_ ? Region::kTable : Region::kNothing;
  const int bin_x = std::min(static_cast<int>((x + half_board_.x()) / kBin), bins_x_ - 1);
  const int bin_y = std::min(static_cast<int>((y + half_board_.y()) / kBin), bins_y_ - 1);
  for (const std::uint16_t index : bins_[std::size_t(bin_y) * bins_x_ + bin_x]) {
    const PlacedTag& tag = tags_[index];
    const Eigen::Vector2f offset = Eigen::Vector2f(x, y) - tag.origin;
    const float column = offset.dot(tag.to_column), row = offset.dot(tag.to_row);
    if (column >= 0 && row >= 0 && column < kTagCells && row < kTagCells)
      return tag.pattern.white[static_cast<int>(row)][static_cast<int>(column)] ? Region::kPaper : Region::kInk;
  }
  return Region::kPaper;
}

Eigen::Array3f StageSurface::albedo(Region region, float x, float y) const {
  switch (region) {
    case Region::kPaper:
      return kPaperAlbedo;
    case Region::kInk:
      return kInkAlbedo;
    case Region::kTable:  // wood: long soft grain along x
      return kTableAlbedo * (1 + 0.35f * fractal_noise(Eigen::Vector3f(x / 0.09f, y / 0.008f, 0), 3));
    case Region::kNothing:
      break;
  }
  return Eigen::Array3f::Zero();
}

}  // namespace sheen
