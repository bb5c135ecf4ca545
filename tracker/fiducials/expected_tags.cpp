// SPDX-License-Identifier: Apache-2.0
#include "tracker/fiducials/expected_tags.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <optional>

#include "tracker/fiducials/grey_sample.h"

namespace sheen {
namespace {

constexpr int kMaxWrongCells = 1;
constexpr double kMinContrast = 20;  // grey levels between paper and ink

/// Grey levels of a tag's cells and of the ring of paper round it: row and column -1 and `kTagCells` are the ring.
using CellLevels = Eigen::Matrix<double, kTagCells + 2, kTagCells + 2>;

Eigen::Vector3d cell_centre(const StageTag& tag, int row, int column) {
  const auto& [top_left, top_right, bottom_right, bottom_left] = tag.corners_object;
  return top_left + (top_right - top_left) * (column + 0.5) / kTagCells +
         (bottom_left - top_left) * (row + 0.5) / kTagCells;
}

/// Empty where the image does not hold all of the tag and its ring.
std::optional<CellLevels> sample_cells(const ImageU8& grey, const Camera& camera, const Rigid3& camera_from_object,
                                       const StageTag& tag) {
  CellLevels levels;
  for (int row = -1; row <= kTagCells; ++row)
    for (int column = -1; column <= kTagCells; ++column) {
      const auto pixel = camera.project(camera_from_object * cell_centre(tag, row, column));
      if (!pixel || !inside(grey, *pixel)) return std::nullopt;
      levels(row + 1, column + 1) = bilinear(grey, *pixel);
    }
  return levels;
}

/// The plane a + b row + c column through the cells of a square frame, `distance` cells inside the ring: light may fall
/// off over a tag.
Eigen::Vector3d level_plane(const CellLevels& levels, int distance) {
  const int first = distance, last = kTagCells + 1 - distance;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (int row = first; row <= last; ++row)
    for (int column = first; column <= last; ++column) {
      if (row != first && row != last && column != first && column != last) continue;
      const Eigen::Vector3d point(1, row, column);
      normal += point * point.transpose();
      right += point * levels(row, column);
    }
  return normal.ldlt().solve(right);
}

bool shows(const CellLevels& levels, const TagPattern& pattern) {
  const Eigen::Vector3d paper = level_plane(levels, 0), ink = level_plane(levels, 1);
  int wrong = 0;
  for (int row = 0; row < kTagCells; ++row)
    for (int column = 0; column < kTagCells; ++column) {
      const Eigen::Vector3d at(1, row + 1, column + 1);
      if (paper.dot(at) - ink.dot(at) < kMinContrast) return false;
      const bool white = levels(row + 1, column + 1) > (paper + ink).dot(at) / 2;
      wrong += white != pattern.white[row][column];
    }
  return wrong <= kMaxWrongCells;
}

std::optional<TagObservation> predicted(const StageTag& tag, const Camera& camera, const Rigid3& camera_from_object) {
  TagObservation observation{.id = tag.id};
  for (int corner = 0; corner < 4; ++corner) {
    const auto pixel = camera.project(camera_from_object * tag.corners_object[corner]);
    if (!pixel) return std::nullopt;
    observation.corners[corner] = *pixel;
  }
  return observation;
}

}  // namespace

ExpectedTags::ExpectedTags(const StageLayout& stage) {
  for (const StageTag& tag : stage.tags) expected_.push_back({tag, tag_pattern(tag.id)});
}

std::vector<TagObservation> ExpectedTags::missing(const ImageU8& grey, const Camera& camera,
                                                  const Rigid3& camera_from_object,
                                                  const std::vector<TagObservation>& found) const {
  std::vector<TagObservation> tags;
  for (const auto& [tag, pattern] : expected_) {
    if (std::ranges::count(found, tag.id, &TagObservation::id) > 0) continue;
    const auto levels = sample_cells(grey, camera, camera_from_object, tag);
    if (!levels || !shows(*levels, pattern)) continue;
    if (auto observation = predicted(tag, camera, camera_from_object)) tags.push_back(*observation);
  }
  return tags;
}

}  // namespace sheen
