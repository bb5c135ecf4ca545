// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/window_matcher.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace sheen {
namespace {

constexpr float kGreyScale = 60;     // a difference of so many levels halves a point's weight
constexpr float kNoiseVariance = 4;  // square grey levels: a window of noise is like nothing
constexpr std::size_t kBest = 3;     // others that count: the rest may not see the place
constexpr float kPerPixel = 0.15f;   // cost of a pixel's way back, ...
constexpr float kMostPixels = 3;     // up to so many

Eigen::Matrix3d matrix_of(const Camera& camera) {
  Eigen::Matrix3d k;
  k << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return k;
}

}  // namespace

WindowMatcher::WindowMatcher(const ShapeView& view, std::vector<const ShapeView*> others)
    : WindowMatcher(view, std::move(others), {}) {}

WindowMatcher::WindowMatcher(const ShapeView& view, std::vector<const ShapeView*> others,
                             std::vector<const ImageF*> depths)
    : view_(view) {
  const Camera& camera = view.camera.camera;
  per_fx_ = static_cast<float>(1 / camera.fx);
  per_fy_ = static_cast<float>(1 / camera.fy);
  cx_ = static_cast<float>(camera.cx);
  cy_ = static_cast<float>(camera.cy);
  const Eigen::Matrix3d k = matrix_of(camera);
  double baselines = 0;
  for (std::size_t i = 0; i < others.size(); ++i) {
    const Rigid3 other_from_view = others[i]->camera.camera_from_object * view.camera.camera_from_object.inverse();
    const Eigen::Matrix3d other_k = matrix_of(others[i]->camera.camera),
                          r = other_from_view.rotation.toRotationMatrix();
    others_.push_back({.grey = &others[i]->grey,
                       .depth = depths.empty() ? nullptr : depths[i],
                       .pixel_from_ray = (other_k * r).cast<float>(),
                       .pixel_of_eye = (other_k * other_from_view.translation).cast<float>(),
                       .view_pixel_from_ray = (k * r.transpose() * other_k.inverse()).cast<float>(),
                       .view_pixel_of_eye = (k * (-(r.transpose() * other_from_view.translation))).cast<float>()});
    baselines += other_from_view.translation.norm() * others[i]->camera.camera.fx;
  }
  if (!others.empty()) depth_per_pixel_ = static_cast<float>(static_cast<double>(others.size()) / baselines);
}

bool WindowMatcher::take(int x, int y) {
  constexpr int kReach = kSide / 2 * kStride;
  const ImageF& grey = view_.grey;
  if (x < kReach || y < kReach || x + kReach >= grey.width() || y + kReach >= grey.height()) return false;
  x_ = x;
  y_ = y;
  ray_ = ray(static_cast<float>(x), static_cast<float>(y));
  const float middle = grey.at(x, y);
  float sum = 0, mean = 0, squares = 0;
  for (int j = 0, k = 0; j < kSide; ++j) {
    const float* row = grey.pixel(x - kReach, y + (j - kSide / 2) * kStride);
    for (int i = 0; i < kSide; ++i, ++k) {
      const float value = row[i * kStride], off = (value - middle) / kGreyScale;
      const auto di = static_cast<float>(i - kSide / 2), dj = static_cast<float>(j - kSide / 2);
      weight_[k] = 1 / (1 + off * off + 0.5f * (di * di + dj * dj));
      centred_[k] = value;
      sum += weight_[k];
      mean += weight_[k] * value;
      squares += weight_[k] * value * value;
    }
  }
  if (!std::isfinite(squares)) return false;
  mean /= sum;
  variance_ = std::max(0.0f, squares / sum - mean * mean);
  for (int k = 0; k < kPoints; ++k) {
    weight_[k] /= sum;
    centred_[k] = weight_[k] * (centred_[k] - mean);
  }
  return true;
}

float WindowMatcher::correlation_cost(const Other& other, const SurfacePiece& piece,
                                      const Eigen::Vector3f& plane) const {
  // A point of the plane on ray q lies at depth 1 / (plane . q), so in the other view at K' R q + K' t (plane . q).
  const Eigen::Vector3f middle = other.pixel_from_ray * ray_ + other.pixel_of_eye / piece.depth;
  const Eigen::Vector3f right = (kStride * per_fx_) * (other.pixel_from_ray.col(0) + other.pixel_of_eye * plane.x());
  const Eigen::Vector3f down = (kStride * per_fy_) * (other.pixel_from_ray.col(1) + other.pixel_of_eye * plane.y());
  constexpr int kHalf = kSide / 2;
  std::array<float, kPoints> u, v;
  for (int j = 0, k = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i, ++k) {
      const auto di = static_cast<float>(i - kHalf), dj = static_cast<float>(j - kHalf);
      const float z = middle.z() + di * right.z() + dj * down.z();
      const float per_z = 1 / z;
      u[k] = (middle.x() + di * right.x() + dj * down.x()) * per_z;
      v[k] = (middle.y() + di * right.y() + dj * down.y()) * per_z;
    }
  const ImageF& grey = *other.grey;
  const auto last_x = static_cast<float>(grey.width() - 1), last_y = static_cast<float>(grey.height() - 1);
  // Seen straight, its corners are the first to leave the image.
  for (const int k : {0, kSide - 1, kPoints - kSide, kPoints - 1})
    if (!(u[k] >= 0 && v[k] >= 0 && u[k] < last_x && v[k] < last_y)) return kWorst;
  const float* pixels = grey.data();
  const int width = grey.width();
  float mean = 0, squares = 0, covariance = 0;
  for (int k = 0; k < kPoints; ++k) {
    const int x = static_cast<int>(u[k]), y = static_cast<int>(v[k]);
    const float s = u[k] - static_cast<float>(x), t = v[k] - static_cast<float>(y);
    const float* above = pixels + std::size_t(y) * width + x;
    const float* below = above + width;
    const float top = above[0] + s * (above[1] - above[0]), bottom = below[0] + s * (below[1] - below[0]);
    const float value = top + t * (bottom - top), weighted = weight_[k] * value;
    mean += weighted;
    squares += weighted * value;
    covariance += centred_[k] * value;
  }
  const float variance = std::max(0.0f, squares - mean * mean);
  const float cost = 1 - covariance / std::sqrt((variance_ + kNoiseVariance) * (variance + kNoiseVariance));
  return cost <= kWorst ? cost : kWorst;  // NaN, too
}

float WindowMatcher::cost_aside(std::size_t number, const SurfacePiece& piece, const Eigen::Vector2f& pixels) const {
  Other aside = others_[number];
  aside.pixel_from_ray.topRows<2>() += pixels * aside.pixel_from_ray.row(2).eval();
  aside.pixel_of_eye.head<2>() += pixels * aside.pixel_of_eye.z();
  return correlation_cost(aside, piece, piece.normal / (piece.normal.dot(ray_) * piece.depth));
}

Eigen::Vector2f WindowMatcher::place_in(std::size_t number, float depth) const {
  const Other& other = others_[number];
  const Eigen::Vector3f there = other.pixel_from_ray * (ray_ * depth) + other.pixel_of_eye;
  return there.z() > 0 ? Eigen::Vector2f(there.hnormalized()) : Eigen::Vector2f::Constant(std::nanf(""));
}

std::optional<WayBack> WindowMatcher::way_back(std::size_t number, int x, int y, float depth) const {
  const Other& other = others_[number];
  const Eigen::Vector3f there =
      other.pixel_from_ray * (ray(static_cast<float>(x), static_cast<float>(y)) * depth) + other.pixel_of_eye;
  const float u = there.x() / there.z(), v = there.y() / there.z();
  const ImageF& depths = *other.depth;
  if (!(there.z() > 0 && u >= 0 && v >= 0 && u <= static_cast<float>(depths.width() - 1) &&
        v <= static_cast<float>(depths.height() - 1)))
    return std::nullopt;
  const float known = depths.at(static_cast<int>(u + 0.5f), static_cast<int>(v + 0.5f));
  if (!(known > 0)) return std::nullopt;
  const Eigen::Vector3f back =
      other.view_pixel_from_ray * Eigen::Vector3f(u * known, v * known, known) + other.view_pixel_of_eye;
  if (!(back.z() > 0)) return std::nullopt;
  const float dx = back.x() / back.z() - static_cast<float>(x), dy = back.y() / back.z() - static_cast<float>(y);
  return WayBack{.pixels = std::sqrt(dx * dx + dy * dy), .depth_off = std::abs(known - there.z()) / there.z()};
}

float WindowMatcher::cost(const SurfacePiece& piece) const {
  const Eigen::Vector3f plane = piece.normal / (piece.normal.dot(ray_) * piece.depth);
  std::array<float, kBest> best;
  best.fill(std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < others_.size(); ++i) {
    float cost = correlation_cost(others_[i], piece, plane);
    if (others_[i].depth) {
      const std::optional<WayBack> back = way_back(i, x_, y_, piece.depth);
      cost += kPerPixel * (back ? std::min(kMostPixels, back->pixels) : kMostPixels);
    }
    for (float& kept : best)
      if (cost < kept) std::swap(cost, kept);
  }
  const std::size_t counted = std::min(kBest, others_.size());
  float sum = 0;
  for (std::size_t i = 0; i < counted; ++i) sum += best[i];
  return counted == 0 ? kWorst : sum / static_cast<float>(counted);
}

}  // namespace sheen
