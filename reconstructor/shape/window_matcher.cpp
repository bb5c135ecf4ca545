// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/window_matcher.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

namespace sheen {
namespace {

constexpr float kGreyScale = 60;     // a difference of so many levels halves a point's weight
constexpr float kNoiseVariance = 4;  // square grey levels: a window of noise is like nothing
constexpr std::size_t kBest = 3;     // others that count: the rest may not see the place
constexpr float kPerPixel = 0.15f;   // cost of a pixel's way back, ...
constexpr float kMostPixels = 3;     // up to so many

constexpr int kSide = 5, kStride = 2, kPoints = kSide * kSide;

/// Where its points are, in strides from the middle.
struct WindowPoints {
  using Lanes = Eigen::Array<float, 32, 1>;
  Lanes across = Lanes::Zero(), down = Lanes::Zero();
  Lanes is_point = Lanes::Zero();  ///< 1; 0 of those that only fill the vectors
  WindowPoints() {
    is_point.head<kPoints>().setOnes();
    for (int k = 0; k < kPoints; ++k) {
      across[k] = static_cast<float>(k % kSide - kSide / 2);
      down[k] = static_cast<float>(k / kSide - kSide / 2);
    }
  }
};
const WindowPoints kWindow;

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
  Lanes value = Lanes::Zero();
  for (int j = 0, k = 0; j < kSide; ++j) {
    const float* row = grey.pixel(x - kReach, y + (j - kSide / 2) * kStride);
    for (int i = 0; i < kSide; ++i, ++k) value[k] = row[i * kStride];
  }
  const Lanes off = (value - grey.at(x, y)) / kGreyScale;
  weight_ = kWindow.is_point / (1 + off.square() + 0.5f * (kWindow.across.square() + kWindow.down.square()));
  weight_ /= weight_.sum();
  const float mean = (weight_ * value).sum(), squares = (weight_ * value.square()).sum();
  if (!std::isfinite(squares)) return false;
  variance_ = std::max(0.0f, squares - mean * mean);
  centred_ = weight_ * (value - mean);
  return true;
}

WindowMatcher::Lanes WindowMatcher::bilinear_at(const Lanes& u, const Lanes& v, const ImageF& grey) {
  using Indices = Eigen::Array<std::int32_t, Lanes::SizeAtCompileTime, 1>;
  const Indices x = u.cast<std::int32_t>(), y = v.cast<std::int32_t>(), at = y * grey.width() + x;
  const Lanes s = u - x.cast<float>(), t = v - y.cast<float>();
  const float* const above = grey.data();
  const float* const below = above + grey.width();
  Lanes a, b, c, d;
  for (int k = 0; k < Lanes::SizeAtCompileTime; ++k) {
    a[k] = above[at[k]];
    b[k] = above[at[k] + 1];
    c[k] = below[at[k]];
    d[k] = below[at[k] + 1];
  }
  const Lanes top = a + s * (b - a), bottom = c + s * (d - c);
  return top + t * (bottom - top);
}

float WindowMatcher::correlation_cost(const Other& other, const SurfacePiece& piece,
                                      const Eigen::Vector3f& plane) const {
  // A point of the plane on ray q lies at depth 1 / (plane . q), so in the other view at K' R q + K' t (plane . q).
  const Eigen::Vector3f middle = other.pixel_from_ray * ray_ + other.pixel_of_eye / piece.depth;
  const Eigen::Vector3f right = (kStride * per_fx_) * (other.pixel_from_ray.col(0) + other.pixel_of_eye * plane.x());
  const Eigen::Vector3f down = (kStride * per_fy_) * (other.pixel_from_ray.col(1) + other.pixel_of_eye * plane.y());
  const Lanes z = middle.z() + kWindow.across * right.z() + kWindow.down * down.z(), per_z = z.inverse();
  const Lanes u = (middle.x() + kWindow.across * right.x() + kWindow.down * down.x()) * per_z;
  const Lanes v = (middle.y() + kWindow.across * right.y() + kWindow.down * down.y()) * per_z;
  const ImageF& grey = *other.grey;
  const auto last_x = static_cast<float>(grey.width() - 1), last_y = static_cast<float>(grey.height() - 1);
  // Seen straight, its corners are the first to leave the image.
  for (const int k : {0, kSide - 1, kPoints - kSide, kPoints - 1})
    if (!(z[k] > 0 && u[k] >= 0 && v[k] >= 0 && u[k] < last_x && v[k] < last_y)) return kWorst;
  const Lanes value = bilinear_at(u, v, grey);
  const float mean = (weight_ * value).sum(), squares = (weight_ * value.square()).sum(),
              covariance = (centred_ * value).sum();
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

float WindowMatcher::cost(const SurfacePiece& piece, float enough) const {
  const Eigen::Vector3f plane = piece.normal / (piece.normal.dot(ray_) * piece.depth);
  const std::size_t counted = std::min(kBest, others_.size());
  const float too_much = enough * static_cast<float>(counted);
  std::array<float, kBest> best;  // in order
  best.fill(std::numeric_limits<float>::infinity());
  const auto sum_of = [&best](std::size_t count) { return std::accumulate(best.begin(), best.begin() + count, 0.0f); };
  for (std::size_t i = 0; i < others_.size(); ++i) {
    float cost = correlation_cost(others_[i], piece, plane);
    if (others_[i].depth) {
      const std::optional<WayBack> back = way_back(i, x_, y_, piece.depth);
      cost += kPerPixel * (back ? std::min(kMostPixels, back->pixels) : kMostPixels);
    }
    for (float& kept : best)
      if (cost < kept) std::swap(cost, kept);
    // As if those that are left were like it without a fault.
    const std::size_t left = others_.size() - 1 - i;
    if (left < counted && sum_of(counted - left) >= too_much) return kWorst;
  }
  return counted == 0 ? kWorst : sum_of(counted) / static_cast<float>(counted);
}

}  // namespace sheen
