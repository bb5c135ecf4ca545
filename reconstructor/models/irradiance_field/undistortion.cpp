// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/undistortion.h"

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "reconstructor/radiance/radiance_image.h"

namespace sheen {
namespace {

constexpr double kFarthest = 2.5;   // tangent of the angle to the axis: 68 degrees
constexpr double kNarrower = 0.99;  // a step of the rectangle where its sides leave the image

/// Tangents of a pixel's ray.
Eigen::Vector2d tangents(const Camera& camera, double x, double y) {
  const auto ray = camera.ray({x, y});
  if (!ray || !(ray->z() > 0) || !(ray->head<2>().norm() < kFarthest * ray->z()))
    throw ConfigError(
        "an irradiance field's pictures are flat, and this lens sees more than 68 degrees to the side; undistort the "
        "images first, or crop them");
  return ray->head<2>() / ray->z();
}

/// In tangents: what lies within all four sides of the image.
struct Rectangle {
  Eigen::Vector2d low{-HUGE_VAL, -HUGE_VAL}, high{HUGE_VAL, HUGE_VAL};
};
Rectangle within_sides(const Camera& camera) {
  Rectangle inside;
  const int right = camera.width - 1, bottom = camera.height - 1;
  for (int y = 0; y <= bottom; ++y) {
    inside.low.x() = std::max(inside.low.x(), tangents(camera, 0, y).x());
    inside.high.x() = std::min(inside.high.x(), tangents(camera, right, y).x());
  }
  for (int x = 0; x <= right; ++x) {
    inside.low.y() = std::max(inside.low.y(), tangents(camera, x, 0).y());
    inside.high.y() = std::min(inside.high.y(), tangents(camera, x, bottom).y());
  }
  return inside;
}

Camera pinhole(const Camera& lens, const Rectangle& view) {
  Camera flat{.width = lens.width, .height = lens.height};
  flat.fx = (lens.width - 1) / (view.high.x() - view.low.x());
  flat.fy = (lens.height - 1) / (view.high.y() - view.low.y());
  flat.cx = -view.low.x() * flat.fx;
  flat.cy = -view.low.y() * flat.fy;
  return flat;
}

/// Where the lens shows what the flat camera's pixels do; empty where it does not show all of it.
std::vector<Eigen::Vector2f> places_of(const Camera& flat, const Camera& lens) {
  std::vector<Eigen::Vector2f> places;
  for (int y = 0; y < flat.height; ++y)
    for (int x = 0; x < flat.width; ++x) {
      const auto at = lens.project({(x - flat.cx) / flat.fx, (y - flat.cy) / flat.fy, 1});
      if (!at || !lens.contains(*at, -1e-6)) return {};
      places.push_back(at->cast<float>());
    }
  return places;
}

}  // namespace

Undistortion::Undistortion(const PosedCamera& camera) : flat_(camera) {
  if (!camera.camera.has_distortion()) return;
  Rectangle view = within_sides(camera.camera);
  while (places_.empty()) {
    if (!((view.high - view.low).minCoeff() > 1e-3))
      throw ConfigError("no flat picture fits into what this lens shows");
    flat_.camera = pinhole(camera.camera, view);
    places_ = places_of(flat_.camera, camera.camera);
    const Eigen::Vector2d middle = (view.low + view.high) / 2;
    view.low = middle + kNarrower * (view.low - middle);
    view.high = middle + kNarrower * (view.high - middle);
  }
}

ImageF Undistortion::of(ImageF image) const {
  if (places_.empty()) return image;
  const RadianceImage lens(image);
  ImageF flat(flat_.camera.width, flat_.camera.height, 3);
  for (std::size_t i = 0; i < places_.size(); ++i)
    Eigen::Map<Eigen::Vector3f>(flat.data() + 3 * i) = lens.sample(places_[i], 1).cwiseMax(0);
  return flat;
}

}  // namespace sheen
