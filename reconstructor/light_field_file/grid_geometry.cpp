// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/grid_geometry.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

namespace sheen {
namespace {

using Vector = std::array<std::int64_t, 3>;

constexpr std::int64_t kUnit = 1 << 20;
constexpr double kFurthestEye = 1 << 30;

std::int64_t largest(const Vector& v) {
  return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
}

std::int64_t dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Scaled to a length of kUnit; 0 stays 0. Entries below 2^62.
Vector of_unit_length(Vector v) {
  // To entries of 30 bits: a short vector keeps all it has, of a long one only rounding is lost.
  const int bits = std::bit_width(static_cast<std::uint64_t>(largest(v)));
  for (std::int64_t& entry : v) entry = bits > 30 ? entry >> (bits - 30) : entry * (std::int64_t{1} << (30 - bits));
  const std::int64_t length = integer_root(dot(v, v));
  if (length == 0) return {};
  for (std::int64_t& entry : v) entry = entry * kUnit / length;
  return v;
}

Vector between(const GridMesh::Point& from, const GridMesh::Point& to) {
  return {std::int64_t{to[0]} - from[0], std::int64_t{to[1]} - from[1], std::int64_t{to[2]} - from[2]};
}

/// Twice the area times the normal. Entries of a mesh's edges are below 2^24.
Vector area_normal(const GridMesh& mesh, const Triangle& triangle) {
  const Vector a = between(mesh.points[triangle[0]], mesh.points[triangle[1]]),
               b = between(mesh.points[triangle[0]], mesh.points[triangle[2]]);
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

std::int64_t integer_root(std::int64_t square) {
  auto root = static_cast<std::int64_t>(std::sqrt(static_cast<double>(square)));  // off by one at the most
  while (root * root > square) --root;
  while ((root + 1) * (root + 1) <= square) ++root;
  return root;
}

std::vector<GridMesh::Point> grid_eyes(const std::vector<PosedCamera>& cameras, const GridMesh& mesh) {
  std::vector<GridMesh::Point> eyes(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Eigen::Vector3d offset = camera_centre(cameras[i].camera_from_object) - mesh.origin.cast<double>();
    for (int axis = 0; axis < 3; ++axis)
      eyes[i][static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(
          std::lround(std::clamp(offset[axis] / static_cast<double>(mesh.step), -kFurthestEye, kFurthestEye)));
  }
  return eyes;
}

GridMesh::Point box_centre(const GridMesh& mesh) {
  if (mesh.points.empty()) return {};
  GridMesh::Point low = mesh.points.front(), high = low;
  for (const GridMesh::Point& point : mesh.points)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], point[axis]);
      high[axis] = std::max(high[axis], point[axis]);
    }
  for (std::size_t axis = 0; axis < 3; ++axis) low[axis] = (low[axis] + high[axis]) / 2;
  return low;
}

std::array<std::int64_t, 3> grid_direction(const GridMesh::Point& from, const GridMesh::Point& to) {
  return of_unit_length(between(from, to));
}

Eigen::Vector3f unit_direction(const GridMesh::Point& from, const GridMesh::Point& to) {
  const Vector offset = between(from, to);
  const double x = static_cast<double>(offset[0]), y = static_cast<double>(offset[1]),
               z = static_cast<double>(offset[2]);
  const double length = std::sqrt(x * x + y * y + z * z);
  if (length == 0) return Eigen::Vector3f::UnitZ();
  return {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)};
}

GridFacing::GridFacing(const GridMesh& mesh) : points_(mesh.points), normals_(mesh.points.size()) {
  constexpr std::int64_t kMost = std::int64_t{1} << 60;  // a damaged file adds up to anything
  for (const Triangle& triangle : mesh.triangles) {
    const Vector normal = area_normal(mesh, triangle);
    for (const std::uint32_t v : triangle)
      for (std::size_t axis = 0; axis < 3; ++axis)
        normals_[v][axis] = std::clamp(normals_[v][axis] + normal[axis], -kMost, kMost);
  }
  for (Vector& normal : normals_) normal = of_unit_length(normal);
}

std::int64_t GridFacing::cosine(std::size_t vertex, const GridMesh::Point& eye) const {
  return dot(normals_[vertex], grid_direction(points_[vertex], eye)) / (kUnit * kUnit / kOne);
}

}  // namespace sheen
