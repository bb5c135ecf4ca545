// SPDX-License-Identifier: Apache-2.0
#pragma once

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
/// sec. 4.2 uses it): mean absolute difference over a window, of those half of the neighbours that agree best, by the
/// best of the windows that the pixel lies in.
class SweepCosts {
 public:
  SweepCosts(const SweepImage& view, std::span<const SweepImage> others, std::vector<double> planes);

  /// Adds those of another light, seen from the same places.
  SweepCosts& operator+=(const SweepCosts& other);

  /// z in camera coordinates of the best plane, refined between planes by a parabola.
  ImageF depth() const;
  /// Variance of the cost over the planes, pooled over 5 x 5 pixels (001 eq. 1): how clearly one plane is best.
  ImageF confidence() const;

 private:
  std::vector<double> planes_;
  std::vector<ImageF> costs_;  ///< per plane
};

/// Medians over 5 x 5 pixels, twice, and their mean over 5 x 5 where the surface is smooth.
ImageF smoothed_depth(const ImageF& depth);

/// Of `count` views, eight (or all, where they are fewer) of those near a view that stand far from each other.
std::vector<std::size_t> spread_neighbours(std::span<const PosedCamera> cameras, std::size_t view);

}  // namespace sheen
