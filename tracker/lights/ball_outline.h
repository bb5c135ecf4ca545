// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/image/image.h"
#include "tracker/lights/ball_view.h"
#include "tracker/lights/rim_circle.h"

namespace sheen {

/// The outline of a ball, in a straightened picture.
struct BallOutline {
  BallCircle circle;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of centre and radius, px^2
  double visible = 0;                                    ///< part of it that lies in the picture
  double support = 0;                                    ///< part of that which shows an edge
};

/// The part of straightened pictures round a ball, of which large ones are made smaller.
class BallCrop {
 public:
  BallCrop(ImageSize picture, const BallCircle& ball);
  bool empty() const { return box_.empty(); }
  ImageF of(const ImageF& picture) const;
  /// Between pixels of the crop and places of the picture.
  Eigen::Vector2d place(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d pixel(const Eigen::Vector2d& place) const;
  double scale() const { return factor_; }  ///< pixels of the picture per pixel of the crop

 private:
  int factor_;
  PixelBox box_;
};

/// What many pictures show round a place where a ball may be.
class BallEvidence {
 public:
  /// `view` must outlive it.
  BallEvidence(const BallView& view, const BallCircle& about);
  /// Linear light of a straightened picture.
  void add(const ImageF& picture);

  /// To a part of a pixel. Empty where fewer than half of it show an edge, or where its place is not known to a
  /// thirtieth of the radius.
  std::optional<BallOutline> outline() const;
  /// What stands still in the pictures, without each pixel's brightest value; zero of one picture.
  ImageF background() const;
  const BallCrop& crop() const { return crop_; }

 private:
  /// Where rays from the middle cross an edge; pixels of the crop.
  std::vector<RimPoint> rim_points(const BallCircle& about, std::size_t rays, const Shown& shown) const;

  const BallView& view_;
  BallCircle about_;
  BallCrop crop_;
  ImageF xx_, xy_, yy_;  ///< structure tensor, added up over the pictures
  ImageF sum_, brightest_;
  int pictures_ = 0;
};

}  // namespace sheen
