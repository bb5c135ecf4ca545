// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/visual_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "reconstructor/shape/outline_distance.h"

namespace sheen {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();  // said against a point

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
                      .outside = rule.outlines ? distance_from_background(view) : ImageF{},
                      .width = camera.width,
                      .height = camera.height});
    outlines_ += views_.back().outside.empty() ? 0 : 1;
  }
}

VisualHull::Place VisualHull::at(const Eigen::Vector3d& point) const {
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
  const int told = static_cast<int>(outlines.size());
  return {.outside = std::max({largest_but(rule_.dissenters(outlines.size()), outlines), seen_by_enough,
                               static_cast<float>(beyond_box.maxCoeff())}),
          .outlines = told};
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
