// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/view_hemisphere.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace sheen {
namespace {

constexpr float kSamePlace = 1e-3f;  ///< Subdiv2D throws when points nearly coincide

using Place = std::pair<int, int>;

Place place(const Eigen::Vector2f& p) {
  return {static_cast<int>(std::lround(p.x() / kSamePlace)), static_cast<int>(std::lround(p.y() / kSamePlace))};
}

std::array<float, 3> barycentric(const Eigen::Vector2f& a, const Eigen::Vector2f& b, const Eigen::Vector2f& c,
                                 const Eigen::Vector2f& p) {
  const auto cross = [](const Eigen::Vector2f& u, const Eigen::Vector2f& v) { return u.x() * v.y() - u.y() * v.x(); };
  const float area = cross(b - a, c - a);
  if (std::abs(area) < 1e-12f) return {-1, -1, -1};
  const float wb = cross(p - a, c - a) / area, wc = cross(b - a, p - a) / area;
  return {1 - wb - wc, wb, wc};
}

}  // namespace

Eigen::Vector2f hemisphere_point(const Eigen::Matrix3f& frame, const Eigen::Vector3f& direction) {
  const Eigen::Vector3f local = frame * direction;
  const Eigen::Vector2f p = local.head<2>();
  return local.z() >= 0 ? p : p / std::max(p.norm(), 1e-6f);
}

ViewTriangulation::Location ViewTriangulation::locate(const Eigen::Vector2f& p) const {
  // Rounding on shared edges must not lose a point: the triangle that comes nearest to holding it wins.
  Location best;
  float best_inside = -1e-4f;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c] = triangles[t];
    const std::array<float, 3> w = barycentric(points.col(a), points.col(b), points.col(c), p);
    const float inside = std::min({w[0], w[1], w[2]});
    if (inside > best_inside) {
      best_inside = inside;
      best = {static_cast<int>(t), w};
      if (inside >= 0) break;
    }
  }
  return best;
}

float ViewTriangulation::area(int triangle) const {
  const auto& [a, b, c] = triangles[triangle];
  const Eigen::Vector2f u = points.col(b) - points.col(a), v = points.col(c) - points.col(a);
  return 0.5f * std::abs(u.x() * v.y() - u.y() * v.x());
}

ViewTriangulation triangulate_views(const Eigen::Matrix3f& frame, const Eigen::Matrix3Xf& directions) {
  ViewTriangulation result;
  result.points.resize(2, ViewTriangulation::kCorners + directions.cols());
  result.points.leftCols<4>() << -1, 1, 1, -1, -1, -1, 1, 1;
  for (Eigen::Index j = 0; j < directions.cols(); ++j)
    result.points.col(ViewTriangulation::kCorners + j) = hemisphere_point(frame, directions.col(j));

  // Subdiv2D closes the plane with points of its own just outside this box; far away they leave the square alone.
  cv::Subdiv2D subdivision(cv::Rect(-1000, -1000, 2000, 2000));
  // Snapped to the grid of places, so that what Subdiv2D gives back can be recognised exactly; of points at one place,
  // the first.
  std::vector<std::pair<Place, std::uint16_t>> points;
  points.reserve(static_cast<std::size_t>(result.points.cols()));
  for (Eigen::Index j = 0; j < result.points.cols(); ++j)
    points.emplace_back(place(result.points.col(j)), static_cast<std::uint16_t>(j));
  std::sort(points.begin(), points.end());
  points.erase(
      std::unique(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.first == b.first; }),
      points.end());
  for (const auto& [at, index] : points) subdivision.insert(cv::Point2f(at.first * kSamePlace, at.second * kSamePlace));
  std::vector<cv::Vec6f> found;
  subdivision.getTriangleList(found);
  result.triangles.reserve(found.size());
  for (const cv::Vec6f& t : found) {
    std::array<std::uint16_t, 3> corners{};
    bool ours = true;  // the list also holds triangles to Subdiv2D's own outer points
    for (int c = 0; c < 3 && ours; ++c) {
      const Place at = place({t[2 * c], t[2 * c + 1]});
      const auto found_at = std::lower_bound(points.begin(), points.end(), std::pair(at, std::uint16_t{0}));
      ours = found_at != points.end() && found_at->first == at;
      if (ours) corners[c] = found_at->second;
    }
    if (ours) result.triangles.push_back(corners);
  }
  return result;
}

Eigen::VectorXf delaunay_weights(const ViewTriangulation& triangulation, const Eigen::Vector2f& point) {
  constexpr int corners = ViewTriangulation::kCorners;
  Eigen::VectorXf weights = Eigen::VectorXf::Zero(triangulation.points.cols() - corners);
  const ViewTriangulation::Location at = triangulation.locate(point);
  if (weights.size() == 0) return weights;
  float total = 0;
  if (at.triangle >= 0)
    for (int c = 0; c < 3; ++c) {
      const int p = triangulation.triangles[at.triangle][c];
      if (p < corners) continue;
      weights[p - corners] += std::max(at.weights[c], 0.0f);
      total += std::max(at.weights[c], 0.0f);
    }
  if (total > 1e-3f) return weights / total;
  Eigen::Index nearest = 0;  // a triangle of map corners alone, or a place exactly on one
  (triangulation.points.rightCols(weights.size()).colwise() - point).colwise().squaredNorm().minCoeff(&nearest);
  weights.setZero();
  weights[nearest] = 1;
  return weights;
}

}  // namespace sheen
