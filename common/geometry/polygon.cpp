// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/polygon.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace sheen {
namespace {

using Point = Eigen::Vector2d;

/// Twice the area, positive where a, b, c turn left.
double turn(const Point& a, const Point& b, const Point& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// The polygon without the coordinate along which it extends least, so that it turns left. Empty: it has no area.
std::vector<Point> flattened(std::span<const Eigen::Vector3d> corners) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 2; i < corners.size(); ++i)
    normal += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
  Eigen::Index across = 0;
  if (!(normal.cwiseAbs().maxCoeff(&across) > 0)) return {};
  Eigen::Index u = (across + 1) % 3, v = (across + 2) % 3;
  if (normal[across] < 0) std::swap(u, v);
  std::vector<Point> flat;
  for (const Eigen::Vector3d& corner : corners) flat.emplace_back(corner[u] - corners[0][u], corner[v] - corners[0][v]);
  return flat;
}

/// Every corner turns left, and all together once round.
bool is_convex(const std::vector<Point>& polygon) {
  const std::size_t n = polygon.size();
  double turned = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % n], &c = polygon[(i + 2) % n];
    const double left = turn(a, b, c);
    if (!(left > 0)) return false;
    turned += std::atan2(left, (b - a).dot(c - b));
  }
  return turned < 3 * M_PI;
}

/// The corners that are left of a polygon, in a ring from which one after the other is clipped.
class EarClipping {
 public:
  explicit EarClipping(const std::vector<Point>& polygon) : points_(polygon) {
    const auto n = static_cast<std::uint32_t>(polygon.size());
    for (std::uint32_t i = 0; i < n; ++i) {
      before_.push_back((i + n - 1) % n);
      after_.push_back((i + 1) % n);
    }
    for (std::uint32_t i = 0; i < n; ++i)
      if (turn_at(i) <= 0) not_convex_.push_back(i);
  }

  std::vector<std::array<std::uint32_t, 3>> run() {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::uint32_t corner = 0;
    for (std::size_t left = points_.size(); left >= 3; --left) {
      corner = next_ear(corner, left);
      triangles.push_back({before_[corner], corner, after_[corner]});
      corner = clip(corner);
    }
    return triangles;
  }

 private:
  enum class Touching { kBlocks, kAllowed };

  double turn_at(std::uint32_t i) const { return turn(points_[before_[i]], points_[i], points_[after_[i]]); }

  /// From `first` on. What crosses itself may have none: then the flattest will do.
  std::uint32_t next_ear(std::uint32_t first, std::size_t left) const {
    for (const Touching touching : {Touching::kBlocks, Touching::kAllowed}) {
      std::uint32_t i = first;
      for (std::size_t k = 0; k < left; ++k, i = after_[i])
        if (is_ear(i, touching)) return i;
    }
    std::uint32_t flattest = first, i = first;
    for (std::size_t k = 0; k < left; ++k, i = after_[i])
      if (std::abs(turn_at(i)) < std::abs(turn_at(flattest))) flattest = i;
    return flattest;
  }

  /// A convex corner whose triangle holds no other; only those that are not convex can be the first to reach into it.
  bool is_ear(std::uint32_t i, Touching touching) const {
    if (!(turn_at(i) > 0)) return false;
    const Point &a = points_[before_[i]], &b = points_[i], &c = points_[after_[i]];
    for (const std::uint32_t other : not_convex_) {
      const Point& p = points_[other];
      if (p == a || p == b || p == c) continue;  // where a bridge to a hole begins
      const double least = std::min({turn(a, b, p), turn(b, c, p), turn(c, a, p)});
      if (touching == Touching::kBlocks ? least >= 0 : least > 0) return false;
    }
    return true;
  }

  /// Returns where to go on: not beside it, which would leave slivers.
  std::uint32_t clip(std::uint32_t i) {
    after_[before_[i]] = after_[i];
    before_[after_[i]] = before_[i];
    std::erase_if(not_convex_,
                  [&](std::uint32_t k) { return k == i || ((k == before_[i] || k == after_[i]) && turn_at(k) > 0); });
    return after_[after_[i]];
  }

  const std::vector<Point>& points_;
  std::vector<std::uint32_t> before_, after_;
  std::vector<std::uint32_t> not_convex_;
};

}  // namespace

std::vector<std::array<std::uint32_t, 3>> polygon_triangles(std::span<const Eigen::Vector3d> corners) {
  const std::vector<Point> flat = corners.size() > 3 ? flattened(corners) : std::vector<Point>{};
  std::vector<std::array<std::uint32_t, 3>> fan;
  if (!flat.empty() && !is_convex(flat)) return flat.size() > kMostCorners ? fan : EarClipping(flat).run();
  for (std::uint32_t i = 2; i < corners.size(); ++i) fan.push_back({0, i - 1, i});
  return fan;
}

}  // namespace sheen
