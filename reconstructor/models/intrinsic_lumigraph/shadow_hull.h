// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "reconstructor/models/intrinsic_lumigraph/intrinsic_view.h"

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
  /// Of views with depth and masks of where each light arrives.
  ShadowHull(std::span<const IntrinsicView* const> views, const LightSet& lights);
  /// As it was stored. `cells`: solidity, 0 to `kSolid`, x fastest.
  ShadowHull(const Eigen::Vector3f& origin, float cell, const Eigen::Vector3i& size, std::vector<std::uint8_t> cells);

  /// Whether something on the way from a point to a lamp is solid, but for what belongs to the point's surface.
  bool hides(const Eigen::Vector3f& point, const Lamp& lamp) const;

  bool empty() const { return cells_.empty(); }
  const Eigen::Vector3f& origin() const { return origin_; }
  float cell() const { return cell_; }
  const Eigen::Vector3i& size() const { return size_; }
  const std::vector<std::uint8_t>& cells() const { return cells_; }

 private:
  /// Calls `visit(cell)` along the way until it says false or the way leaves the grid.
  template <typename Visit>
  void walk(const Eigen::Vector3f& from, const Eigen::Vector3f& direction, float length, const Visit& visit) const;
  /// Interpolated between the centres of cells; negative outside.
  float solidity(const Eigen::Vector3f& place) const;
  void place_grid(std::span<const IntrinsicView* const> views);
  void look_through(std::span<const IntrinsicView* const> views);
  /// Along the way from a point to a lamp, but for where it begins: the surface itself.
  template <typename Visit>
  void walk_to_lamp(const Eigen::Vector3f& point, const Lamp& lamp, const Visit& visit) const;
  /// How many ways of a lamp's light pass through each cell, and how many of them end at a pixel that is lit.
  struct LightWays {
    std::vector<std::uint16_t> all, lit;
    explicit LightWays(std::size_t cells) : all(cells), lit(cells) {}
  };
  void shine_through(const IntrinsicView& view, const ImageU8& bright, const LightSet& lights, int light,
                     LightWays& ways) const;

  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();  ///< corner of the first cell
  float cell_ = 0;                                    ///< metres along a side
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  std::vector<std::uint8_t> cells_;
};

/// Part of each pixel of a view that a lamp reaches, 0..255, by a hull; edges are smoothed over two pixels.
ImageU8 reached_past(const ShadowHull& hull, const IntrinsicView& view, const Lamp& lamp);

}  // namespace sheen
