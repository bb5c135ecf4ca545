// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/image/image.h"

namespace sheen {

/// One image of a sweep: where it was taken from, and its brightness as the eye sees it (encoded, 1 channel).
struct SweepImage {
  PosedCamera from;
  const ImageF* grey = nullptr;
};

/// Depths at which planes stand before a camera: even in inverse depth, so close that the image of a neighbour moves by
/// half a pixel from one to the next, within bounds.
std::vector<double> sweep_planes(const PosedCamera& from, std::span<const SweepImage> others, double near, double far);

/// How well a view's image agrees with its neighbours', per plane and pixel (after Kang, Szeliski and Chai 2001, as 001
/// sec. 4.2 uses it): mean absolute difference over a window, of the two of eight neighbours that agree best, by the
/// best of the windows that the pixel lies in.
class SweepCosts {
 public:
  SweepCosts(const SweepImage& view, std::span<const SweepImage> others, std::vector<double> planes);

  /// Adds those of another light, seen from the same places.
  SweepCosts& operator+=(const SweepCosts& other);

  Image<std::uint16_t> best_planes() const;  ///< per pixel
  /// z in camera coordinates of the best plane, refined between planes by a parabola.
  ImageF depth() const;
  /// Variance of the cost over the planes, pooled over 5 x 5 pixels (001 eq. 1): how clearly one plane is best.
  ImageF confidence() const;

 private:
  std::vector<double> planes_;
  std::vector<ImageF> costs_;  ///< per plane
};

/// Depth between the planes that were chosen per pixel. What a plane is chosen by is not accurate: its windows are
/// large and shift. Small ones that stay where they are have less error once the plane is known.
class RefinedDepth {
 public:
  RefinedDepth(std::vector<double> planes, Image<std::uint16_t> best);
  /// Images in one light.
  void add(const SweepImage& view, std::span<const SweepImage> others);
  ImageF depth() const;  ///< z in camera coordinates

 private:
  std::vector<double> planes_;
  Image<std::uint16_t> best_;
  std::vector<PixelBox> parts_;  ///< per plane: what has it for one of the three
  ImageF costs_;                 ///< per pixel: of the plane before the best one, of that, of the one behind
};

/// Medians over 5 x 5 pixels, twice, and their mean over 5 x 5 where the surface is smooth.
ImageF smoothed_depth(const ImageF& depth);

/// Of `count` views, eight (or all, where they are fewer) of those near a view that stand far from each other.
std::vector<std::size_t> spread_neighbours(std::span<const PosedCamera> cameras, std::size_t view);

}  // namespace sheen
