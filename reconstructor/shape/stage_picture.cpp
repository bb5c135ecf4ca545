// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/stage_picture.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/stage/tag_pattern.h"

namespace sheen {
namespace {

constexpr double kFinest = 0.25e-3;  // cell of the raster, metres
constexpr double kMostCells = 2048;  // along its longer side

}  // namespace

StagePicture::StagePicture(const StageLayout& stage) : tags_(stage.tags.size()) {
  double quiet = 0;
  for (const StageTag& tag : stage.tags) {
    for (const Eigen::Vector3d& corner : tag.corners_object) known_.extend(corner.head<2>().eval());
    quiet = std::max(quiet, (tag.corners_object[1] - tag.corners_object[0]).norm() / kTagCells);
  }
  if (known_.isEmpty()) return;
  known_ = {known_.min() - Eigen::Vector2d::Constant(quiet), known_.max() + Eigen::Vector2d::Constant(quiet)};
  cell_ = std::max(kFinest, known_.sizes().maxCoeff() / kMostCells);
  size_ = (known_.sizes().array() / cell_).ceil().cast<int>().max(1);
  tag_.assign(std::size_t(size_.x()) * size_.y(), -1);
  std::vector<bool> ink(tag_.size());
  for (std::size_t number = 0; number < stage.tags.size(); ++number) {
    const auto& corners = stage.tags[number].corners_object;
    const TagPattern pattern = tag_pattern(stage.tags[number].id);
    const Eigen::Vector2d origin = corners[0].head<2>();
    Eigen::Matrix2d axes;  // of a square, as tags are
    axes << corners[1].head<2>() - origin, corners[3].head<2>() - origin;
    if (!(std::abs(axes.determinant()) > 0)) continue;
    const Eigen::Matrix2d from_offset = kTagCells * axes.inverse();
    Eigen::AlignedBox2d part;
    for (const double u : {-1.0 / kTagCells, 1 + 1.0 / kTagCells})
      for (const double v : {-1.0 / kTagCells, 1 + 1.0 / kTagCells})
        part.extend((origin + axes * Eigen::Vector2d(u, v)).eval());
    const Eigen::Array2i first = raster_place(part.min()), last = raster_place(part.max());
    for (int y = first.y(); y <= last.y(); ++y)
      for (int x = first.x(); x <= last.x(); ++x) {
        const Eigen::Vector2d point = known_.min() + cell_ * Eigen::Vector2d(x + 0.5, y + 0.5);
        const Eigen::Array2d place = from_offset * (point - origin);
        if ((place < -1).any() || (place > kTagCells + 1).any()) continue;
        const std::size_t at = x + std::size_t(size_.x()) * y;
        tag_[at] = static_cast<std::int16_t>(number);
        const Eigen::Array2i cell = place.floor().cast<int>();
        if ((cell >= 0).all() && (cell < kTagCells).all()) ink[at] = !pattern.white[cell.y()][cell.x()];
      }
  }
  sums_.assign((std::size_t(size_.x()) + 1) * (size_.y() + 1), 0);
  for (int y = 0; y < size_.y(); ++y)
    for (int x = 0; x < size_.x(); ++x)
      sum(x + 1, y + 1) = sum(x, y + 1) + sum(x + 1, y) - sum(x, y) + (ink[x + std::size_t(size_.x()) * y] ? 1u : 0u);
}

Eigen::Array2i StagePicture::raster_place(const Eigen::Vector2d& point) const {
  const Eigen::Array2d place = ((point - known_.min()) / cell_).array().floor();
  return place.max(0).min((size_ - 1).cast<double>()).cast<int>();
}

float StagePicture::ink(const Eigen::AlignedBox2d& part) const {
  const Eigen::Array2i low = raster_place(part.min()), high = raster_place(part.max()) + 1;
  const std::uint32_t cells =
      sum(high.x(), high.y()) - sum(low.x(), high.y()) - sum(high.x(), low.y()) + sum(low.x(), low.y());
  return static_cast<float>(cells) / static_cast<float>((high - low).prod());
}

int StagePicture::tag_at(const Eigen::Vector2d& point) const {
  const Eigen::Array2i place = raster_place(point);
  return tag_[place.x() + std::size_t(size_.x()) * place.y()];
}

}  // namespace sheen
