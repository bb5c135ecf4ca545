// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "reconstructor/shape/shape_view.h"

namespace sheen {

/// A piece of the surface at a pixel: a plane, in the camera's frame.
struct SurfacePiece {
  float depth = 0;         ///< along z, metres
  Eigen::Vector3f normal;  ///< unit, towards the camera
};

/// From a pixel to its surface, on to what another view holds for the surface there, and back.
struct WayBack {
  float pixels = 0;     ///< from where it began
  float depth_off = 0;  ///< of the two surfaces in the other view, over the depth
};

/// How alike a window of one view looks to others, were the surface there a given plane: normalised cross-correlation
/// over a slanted window, in which what has another grey than the middle counts less (bilateral weights), so that a
/// window over an outline follows the middle's surface.
class WindowMatcher {
 public:
  static constexpr float kWorst = 2;  ///< cost of what cannot be compared

  /// `others` must outlive it.
  WindowMatcher(const ShapeView& view, std::vector<const ShapeView*> others);
  /// With the depths of the surfaces that the others see: to the cost of each comes how far its own depth leads away
  /// from the pixel.
  WindowMatcher(const ShapeView& view, std::vector<const ShapeView*> others, std::vector<const ImageF*> depths);

  /// The window that is compared from now on; false where it cannot be used.
  bool take(int x, int y);
  /// Mean cost of those others, three at most, to which it looks most alike. What is not below `enough` need not be
  /// found: then it is `kWorst`.
  float cost(const SurfacePiece& piece, float enough = std::numeric_limits<float>::infinity()) const;
  /// Cost of one of the others, were its image moved by so many pixels.
  float cost_aside(std::size_t other, const SurfacePiece& piece, const Eigen::Vector2f& pixels) const;

  /// Where a place of the window's middle ray falls in another view; not finite where it lies behind it.
  Eigen::Vector2f place_in(std::size_t other, float depth) const;

  /// Empty where the other view knows no surface.
  std::optional<WayBack> way_back(std::size_t other, int x, int y, float depth) const;

  Eigen::Vector3f ray(float x, float y) const { return {(x - cx_) * per_fx_, (y - cy_) * per_fy_, 1}; }
  /// How far along z the surface is to move so that it moves by a pixel in another view, metres.
  float depth_per_pixel(float depth) const { return depth * depth * depth_per_pixel_; }
  std::size_t others() const { return others_.size(); }

 private:
  /// The 25 points of a window, and some without weight, so that they fill vectors of any processor.
  using Lanes = Eigen::Array<float, 32, 1>;

  struct Other {
    const ImageF* grey;
    const ImageF* depth;                  ///< of its surface; null: not known
    Eigen::Matrix3f pixel_from_ray;       ///< K' R
    Eigen::Vector3f pixel_of_eye;         ///< K' t
    Eigen::Matrix3f view_pixel_from_ray;  ///< back: K R^T K'^-1
    Eigen::Vector3f view_pixel_of_eye;
  };
  static Lanes bilinear_at(const Lanes& u, const Lanes& v, const ImageF& grey);
  float correlation_cost(const Other& other, const SurfacePiece& piece, const Eigen::Vector3f& plane) const;

  const ShapeView& view_;
  std::vector<Other> others_;
  float per_fx_, per_fy_, cx_, cy_, depth_per_pixel_ = 0;
  int x_ = 0, y_ = 0;
  Eigen::Vector3f ray_;
  Lanes weight_, centred_;  ///< sum 1; weight times grey less its mean
  float variance_ = 0;
};

}  // namespace sheen
