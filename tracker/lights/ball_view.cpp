// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/ball_view.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tracker/lights/image_matrix.h"

namespace sheen {
namespace {

/// Stereographic projection from the point opposite to the optical axis; near the axis an angle is its length.
Eigen::Vector2d stereographic(const Eigen::Vector3d& ray) {
  return 2 * ray.head<2>() / (1 + ray.z());
}
Eigen::Vector3d ray_of(const Eigen::Vector2d& m) {
  const double squared = m.squaredNorm();
  return {4 * m.x() / (4 + squared), 4 * m.y() / (4 + squared), (4 - squared) / (4 + squared)};
}

}  // namespace

BallView::BallView(ImageSize image) : size_(image), image_size_(image) {}

BallView::BallView(const Camera& camera) : image_size_{camera.width, camera.height}, camera_(camera) {
  Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
  const auto reach = [&](double x, double y) {
    if (const auto ray = camera.ray({x, y})) {
      const Eigen::Array2d at = camera.fx * stereographic(*ray).array();
      low = low.min(at);
      high = high.max(at);
    }
  };
  for (int x = 0; x < camera.width; ++x) reach(x, 0), reach(x, camera.height - 1);
  for (int y = 0; y < camera.height; ++y) reach(0, y), reach(camera.width - 1, y);
  axis_ = -low;
  size_ = {static_cast<int>(std::ceil(high.x() - low.x())) + 1, static_cast<int>(std::ceil(high.y() - low.y())) + 1};
  map_x_ = map_y_ = ImageF(size_.width, size_.height, 1, -1);
  for (int y = 0; y < size_.height; ++y)
    for (int x = 0; x < size_.width; ++x)
      if (const auto pixel = pixel_of({x, y})) {
        map_x_.at(x, y) = static_cast<float>(pixel->x());
        map_y_.at(x, y) = static_cast<float>(pixel->y());
      }
}

ImageF BallView::straighten(const ImageF& image) const {
  if (!camera_) return image;
  ImageF straight(size_.width, size_.height, 1);
  cv::Mat out = wrapped(straight);
  cv::remap(wrapped(image), out, wrapped(map_x_), wrapped(map_y_), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return straight;
}

std::optional<Eigen::Vector3d> BallView::ray(const Eigen::Vector2d& place) const {
  if (!camera_) return std::nullopt;
  return ray_of((place - axis_) / camera_->fx);
}

std::optional<Eigen::Vector2d> BallView::pixel_of(const Eigen::Vector2d& place) const {
  return camera_ ? camera_->project(*ray(place)) : place;
}

Eigen::Vector2d BallView::place_of(const Eigen::Vector2d& pixel) const {
  if (!camera_) return pixel;
  // Beyond what the lens sees: as a pinhole would.
  const Eigen::Vector3d pinhole((pixel.x() - camera_->cx) / camera_->fx, (pixel.y() - camera_->cy) / camera_->fy, 1);
  return axis_ + camera_->fx * stereographic(camera_->ray(pixel).value_or(pinhole.normalized()));
}

bool BallView::shows(const Eigen::Vector2d& place) const {
  const auto pixel = pixel_of(place);
  return pixel && pixel->x() >= 0 && pixel->y() >= 0 && pixel->x() <= image_size_.width - 1 &&
         pixel->y() <= image_size_.height - 1;
}

BallCircle BallView::straightened(const BallCircle& in_image) const {
  const Eigen::Vector2d across(in_image.radius, 0);
  const Eigen::Vector2d left = place_of(in_image.centre - across), right = place_of(in_image.centre + across);
  return {(left + right) / 2, (right - left).norm() / 2};
}

BallCircle BallView::in_image(const BallCircle& straightened) const {
  const Eigen::Vector2d across(straightened.radius, 0);
  const auto left = pixel_of(straightened.centre - across), right = pixel_of(straightened.centre + across);
  if (!left || !right) return straightened;
  return {(*left + *right) / 2, (*right - *left).norm() / 2};
}

MirrorBall::MirrorBall(const BallView& view, const BallCircle& circle) : view_(view), circle_(circle) {
  // The rays u of a ball's outline have u . w = 1, w the ball's direction over the cosine of the angle it reaches to.
  Eigen::Matrix3d rays;
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * M_PI * i / 3;
    const auto ray = view.ray(circle.centre + circle.radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    if (!ray) return;
    rays.row(i) = ray->transpose();
  }
  const Eigen::Vector3d w = rays.partialPivLu().solve(Eigen::Vector3d::Ones());
  const double cosine = 1 / w.norm();
  centre_ = w * cosine / std::sqrt(1 - cosine * cosine);
}

std::optional<Eigen::Vector3d> MirrorBall::light_at(const Eigen::Vector2d& place) const {
  Eigen::Vector3d normal, ray(0, 0, 1);
  if (const auto through = view_.ray(place)) {
    ray = *through;
    const double along = ray.dot(centre_), inside = along * along - (centre_.squaredNorm() - 1);
    if (!(inside > 0)) return std::nullopt;
    normal = (along - std::sqrt(inside)) * ray - centre_;
  } else {
    const Eigen::Vector2d at = (place - circle_.centre) / circle_.radius;
    const double inside = 1 - at.squaredNorm();
    if (!(inside > 0)) return std::nullopt;
    normal = {at.x(), at.y(), -std::sqrt(inside)};
  }
  const Eigen::Vector3d towards = ray - 2 * ray.dot(normal) * normal;
  return Eigen::Vector3d(towards.x(), -towards.y(), -towards.z()).normalized();
}

}  // namespace sheen
