// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/visual_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace sheen {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();  // said against a point

/// Pixels from the outline, negative on what may be the object; empty where nothing is background or nothing object.
/// NaN: of what is unknown beside a sheet, nothing is said.
ImageF distances_from(const ShapeView& view) {
  const ImageU8& outline = view.outline;
  if (outline.empty()) return {};
  cv::Mat background(outline.height(), outline.width(), CV_8U);
  bool any_object = false;
  for (int y = 0; y < outline.height(); ++y)
    for (int x = 0; x < outline.width(); ++x) {
      const auto mark = static_cast<Outline>(outline.at(x, y));
      background.at<std::uint8_t>(y, x) = mark == Outline::kBackground ? 255 : 0;
      any_object = any_object || mark == Outline::kObject;
    }
  if (!any_object || cv::countNonZero(background) == 0) return {};
  cv::Mat outside, inside;
  cv::distanceTransform(background, outside, cv::DIST_L2, cv::DIST_MASK_5, CV_32F);
  cv::bitwise_not(background, background);
  cv::distanceTransform(background, inside, cv::DIST_L2, cv::DIST_MASK_5, CV_32F);
  ImageF distance(outline.width(), outline.height(), 1);
  for (int y = 0; y < outline.height(); ++y)
    for (int x = 0; x < outline.width(); ++x) {
      const float out = outside.at<float>(y, x), in = inside.at<float>(y, x);
      distance.at(x, y) = out > 0 ? out - 0.5f : 0.5f - in;
      if (view.before_sheet && outline.at(x, y) == static_cast<std::uint8_t>(Outline::kUnknown))
        distance.at(x, y) = std::numeric_limits<float>::quiet_NaN();
    }
  return distance;
}

float bilinear(const ImageF& image, float x, float y) {
  const float u = std::clamp(x, 0.0f, static_cast<float>(image.width() - 1));
  const float v = std::clamp(y, 0.0f, static_cast<float>(image.height() - 1));
  const int x0 = std::min(static_cast<int>(u), std::max(0, image.width() - 2));
  const int y0 = std::min(static_cast<int>(v), std::max(0, image.height() - 2));
  const int x1 = std::min(x0 + 1, image.width() - 1), y1 = std::min(y0 + 1, image.height() - 1);
  const float s = u - static_cast<float>(x0), t = v - static_cast<float>(y0);
  return (1 - t) * ((1 - s) * image.at(x0, y0) + s * image.at(x1, y0)) +
         t * ((1 - s) * image.at(x0, y1) + s * image.at(x1, y1));
}

/// The (number + 1)-th largest.
float largest_but(int number, std::span<float> values) {
  if (number >= static_cast<int>(values.size())) return kNothing;
  std::nth_element(values.begin(), values.begin() + number, values.end(), std::greater<>());
  return values[number];
}

}  // namespace

VisualHull::VisualHull(std::span<const ShapeView> views, const Eigen::AlignedBox3d& box, const HullRule& rule)
    : box_(box), rule_(rule) {
  for (const ShapeView& view : views) {
    const Camera& camera = view.camera.camera;
    Eigen::Matrix3d k;
    k << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
    Eigen::Matrix<double, 3, 4> from_centred;
    from_centred.leftCols<3>() = k * view.camera.camera_from_object.rotation.toRotationMatrix();
    from_centred.col(3) = k * (view.camera.camera_from_object * box.center());
    views_.push_back({.pixel_from_object = from_centred.cast<float>(),
                      .metres_per_pixel = static_cast<float>(2 / (camera.fx + camera.fy)),
                      .outside = rule.outlines ? distances_from(view) : ImageF{},
                      .width = camera.width,
                      .height = camera.height});
    outlines_ += views_.back().outside.empty() ? 0 : 1;
  }
}

float VisualHull::distance(const Eigen::Vector3d& point) const {
  const Eigen::Vector3f centred = (point - box_.center()).cast<float>();
  thread_local std::vector<float> outlines, frames;
  outlines.clear();
  frames.clear();
  for (const View& view : views_) {
    const Eigen::Vector3f p = view.pixel_from_object * centred.homogeneous();
    if (!(p.z() > 0)) {
      frames.push_back(-kNothing);
      continue;
    }
    const float x = p.x() / p.z(), y = p.y() / p.z(), metres = view.metres_per_pixel * p.z();
    const auto right = static_cast<float>(view.width - 1), bottom = static_cast<float>(view.height - 1);
    const float beyond = std::max({-x, x - right, -y, y - bottom});
    frames.push_back(metres * beyond);
    if (beyond > 0 || view.outside.empty()) continue;  // it shows nothing of the point
    const float outside = bilinear(view.outside, x, y);
    if (!std::isnan(outside)) outlines.push_back(metres * outside);
  }
  const double unseeing = 1 - rule_.must_see;
  const float seen_by_enough = largest_but(static_cast<int>(unseeing * static_cast<double>(frames.size())), frames);
  const Eigen::Vector3d beyond_box = (point - box_.center()).cwiseAbs() - 0.5 * box_.sizes();
  return std::max({largest_but(rule_.dissenters(outlines.size()), outlines), seen_by_enough,
                   static_cast<float>(beyond_box.maxCoeff())});
}

BlockField hull_field(const VisualHull& hull, const Lattice& lattice, const ForEach& for_each) {
  BlockField field(lattice);
  const Eigen::Array3i blocks = field.blocks();
  const auto block_number = [&](std::size_t i) {
    const int n = static_cast<int>(i);
    return Eigen::Array3i(n % blocks.x(), n / blocks.x() % blocks.y(), n / (blocks.x() * blocks.y()));
  };
  const std::size_t all = blocks.prod();
  // Distances change by no more than the way, along a ray by a little more, and by more where a view's frame ends: so
  // there are probes all over a block, each of which stands for what is round it.
  constexpr int kProbes = 3;  // along a side
  constexpr double kApart = double(BlockField::kSide - 1) / (kProbes - 1);
  const double reach = 1.4 * std::sqrt(3.0) * 0.5 * (kApart + 1) * lattice.cell;
  std::vector<std::int8_t> side(all);  // -1: all inside, 1: all outside
  for_each(all, [&](std::size_t i) {
    const Eigen::Array3d first = (BlockField::kSide * block_number(i)).cast<double>();
    int inside = 0, outside = 0;
    for (int n = 0; n < kProbes * kProbes * kProbes && (inside == n || outside == n); ++n) {
      const Eigen::Array3d probe =
          first + kApart * Eigen::Array3d(n % kProbes, n / kProbes % kProbes, n / (kProbes * kProbes));
      const double distance = hull.distance(lattice.origin + lattice.cell * probe.matrix());
      inside += distance < -reach ? 1 : 0;
      outside += distance > reach ? 1 : 0;
    }
    constexpr int kAll = kProbes * kProbes * kProbes;
    side[i] = static_cast<std::int8_t>(inside == kAll ? -1 : outside == kAll ? 1 : 0);
  });
  for (std::size_t i = 0; i < all; ++i) {
    if (side[i] != 0)
      field.fill(block_number(i), side[i] < 0);
    else
      field.store(block_number(i));
  }
  for_each(field.stored(), [&](std::size_t i) {
    const Eigen::Array3i block = field.stored_blocks()[i];
    float* value = field.values(block);
    for (int z = 0; z < BlockField::kSide; ++z)
      for (int y = 0; y < BlockField::kSide; ++y)
        for (int x = 0; x < BlockField::kSide; ++x)
          *value++ = hull.distance(lattice.at(BlockField::kSide * block + Eigen::Array3i(x, y, z)));
  });
  return field;
}

Lattice lattice_over(const Eigen::AlignedBox3d& box, double cell) {
  constexpr int kMargin = 2;
  const Eigen::Array3i cells = (box.sizes().array() / cell).ceil().cast<int>() + 2 * kMargin;
  return {.origin = box.center() - 0.5 * cell * cells.cast<double>().matrix(), .cell = cell, .points = cells + 1};
}

}  // namespace sheen
