// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/camera/camera.h"
#include "common/image/image.h"

namespace sheen {

/// The outline of a ball in a straightened picture, pixels.
struct BallCircle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0;
};

/// Pictures in which the outline of every ball is a circle. Of a camera that is far away they are its images: rays are
/// parallel. Of a calibrated camera they are in stereographic projection, which maps circles on the sphere of
/// directions (a ball's outline is one) to circles; the lens is undone with it.
class BallView {
 public:
  explicit BallView(ImageSize image);
  explicit BallView(const Camera& camera);

  ImageSize size() const { return size_; }
  /// `image`: of the camera's size, 1 channel.
  ImageF straighten(const ImageF& image) const;
  /// Whether the camera's image has this place of a straightened picture.
  bool shows(const Eigen::Vector2d& place) const;
  /// A circle about a pixel of the image, and back; for an outline that is not quite a circle there, about.
  BallCircle straightened(const BallCircle& in_image) const;
  BallCircle in_image(const BallCircle& straightened) const;
  /// Unit ray of a place in camera coordinates. Empty where rays are parallel.
  std::optional<Eigen::Vector3d> ray(const Eigen::Vector2d& place) const;

 private:
  Eigen::Vector2d place_of(const Eigen::Vector2d& pixel) const;
  std::optional<Eigen::Vector2d> pixel_of(const Eigen::Vector2d& place) const;

  ImageSize size_, image_size_;
  std::optional<Camera> camera_;
  Eigen::Vector2d axis_ = Eigen::Vector2d::Zero();  ///< place of the optical axis
  ImageF map_x_, map_y_;                            ///< pixels of the image by place
};

/// A mirror ball: which far light is seen at which of its places.
class MirrorBall {
 public:
  /// `view` must outlive it.
  MirrorBall(const BallView& view, const BallCircle& circle);
  /// Unit direction from the ball to the light that is mirrored at `place`, in the axes of a list of lights: x right
  /// and y up in the picture, z towards the camera. Empty outside the outline.
  std::optional<Eigen::Vector3d> light_at(const Eigen::Vector2d& place) const;

 private:
  const BallView& view_;
  BallCircle circle_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();  ///< camera coordinates, radii; of a calibrated camera
};

}  // namespace sheen
