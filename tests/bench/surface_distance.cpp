// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sheen {
namespace {

constexpr std::uint32_t kLeaf = 4;  // triangles

double distance_to_segment(const Eigen::Vector3d& point, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = b - a;
  const double length = along.squaredNorm();
  const double t = length > 0 ? std::clamp((point - a).dot(along) / length, 0.0, 1.0) : 0.0;
  return (point - a - t * along).norm();
}

}  // namespace

double distance_to_triangle(const Eigen::Vector3d& point, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  const auto left_of = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return (to - from).cross(point - from).dot(normal) >= 0;
  };
  if (normal.norm() > 0 && left_of(a, b) && left_of(b, c) && left_of(c, a))
    return std::abs((point - a).dot(normal.normalized()));
  return std::min(
      {distance_to_segment(point, a, b), distance_to_segment(point, b, c), distance_to_segment(point, c, a)});
}

SurfaceDistance::SurfaceDistance(const Mesh& mesh) : triangles_(mesh.triangles) {
  for (const Eigen::Vector3f& vertex : mesh.vertices) vertices_.push_back(vertex.cast<double>() + mesh.origin);
  if (!triangles_.empty()) build(0, static_cast<std::uint32_t>(triangles_.size()));
}

std::uint32_t SurfaceDistance::build(std::uint32_t first, std::uint32_t count) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({.box = {}, .first = first, .count = count});
  for (std::uint32_t t = first; t < first + count; ++t)
    for (int c = 0; c < 3; ++c) nodes_[number].box.extend(corner(t, c));
  if (count <= kLeaf) return number;
  int axis = 0;
  nodes_[number].box.sizes().maxCoeff(&axis);
  const auto middle = [&](const Triangle& t) {
    return vertices_[t[0]][axis] + vertices_[t[1]][axis] + vertices_[t[2]][axis];
  };
  const auto begin = triangles_.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count,
                   [&](const Triangle& s, const Triangle& t) { return middle(s) < middle(t); });
  nodes_[number].count = 0;
  build(first, count / 2);
  const std::uint32_t second = build(first + count / 2, count - count / 2);
  nodes_[number].second = second;
  return number;
}

void SurfaceDistance::nearest(std::uint32_t number, const Eigen::Vector3d& point, double& best) const {
  const Node& node = nodes_[number];
  if (node.box.exteriorDistance(point) >= best) return;
  for (std::uint32_t t = node.first; t < node.first + node.count; ++t)
    best = std::min(best, distance_to_triangle(point, corner(t, 0), corner(t, 1), corner(t, 2)));
  if (node.count > 0) return;
  std::uint32_t near = number + 1, far = node.second;
  if (nodes_[far].box.exteriorDistance(point) < nodes_[near].box.exteriorDistance(point)) std::swap(near, far);
  nearest(near, point, best);
  nearest(far, point, best);
}

double SurfaceDistance::to(const Eigen::Vector3d& point) const {
  double best = std::numeric_limits<double>::infinity();
  if (!nodes_.empty()) nearest(0, point, best);
  return best;
}

}  // namespace sheen
