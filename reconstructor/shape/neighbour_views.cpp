// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/neighbour_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sheen {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kLeast = 3 * kDegree, kBest = 11 * kDegree, kMost = 45 * kDegree;

/// Unit directions to the cameras, and their distances.
struct Directions {
  std::vector<Eigen::Vector3d> unit;
  std::vector<double> distance;
};

Directions directions_from(const Eigen::Vector3d& place, std::span<const PosedCamera> cameras) {
  Directions to;
  for (const PosedCamera& camera : cameras) {
    const Eigen::Vector3d way = camera_centre(camera.camera_from_object) - place;
    to.distance.push_back(way.norm());
    to.unit.push_back(way / std::max(way.norm(), 1e-300));
  }
  return to;
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
}

/// Too near tells little of depth, too far looks different.
double worth(double angle, double farther) {
  if (angle < kLeast || angle > kMost) return 0;
  const double off = angle < kBest ? (kBest - angle) / (0.5 * kBest) : (angle - kBest) / kBest;
  return std::exp(-0.5 * off * off) / (farther * farther);
}

}  // namespace

std::vector<std::vector<std::size_t>> neighbour_views(std::span<const PosedCamera> cameras,
                                                      const Eigen::Vector3d& place, std::size_t most) {
  const Directions to = directions_from(place, cameras);
  std::vector<std::vector<std::size_t>> neighbours(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    std::vector<double> left(cameras.size(), 0);
    for (std::size_t j = 0; j < cameras.size(); ++j) {
      if (j == i) continue;
      const double ratio = to.distance[i] / to.distance[j];
      left[j] = worth(angle_between(to.unit[i], to.unit[j]), std::max(ratio, 1 / ratio));
    }
    while (neighbours[i].size() < most) {
      const std::size_t best = std::max_element(left.begin(), left.end()) - left.begin();
      if (!(left[best] > 0)) break;
      neighbours[i].push_back(best);
      left[best] = 0;
      // One that looks from where another does adds little.
      const Eigen::Vector3d side = (to.unit[best] - to.unit[i]).normalized();
      for (std::size_t j = 0; j < cameras.size(); ++j) {
        const double same = (to.unit[j] - to.unit[i]).normalized().dot(side);
        const double near = angle_between(to.unit[j], to.unit[best]) / kBest;
        left[j] *= (1 - 0.25 * std::max(0.0, same)) * (1 - 0.5 * std::exp(-near * near * 4));
      }
    }
  }
  return neighbours;
}

std::vector<std::size_t> spread_views(std::span<const PosedCamera> cameras, const Eigen::Vector3d& place,
                                      std::size_t most) {
  std::vector<std::size_t> chosen;
  const Directions to = directions_from(place, cameras);
  std::vector<double> apart(cameras.size(), std::numeric_limits<double>::infinity());
  std::vector<bool> taken(cameras.size(), false);
  std::size_t next = 0;
  while (chosen.size() < std::min(most, cameras.size())) {
    chosen.push_back(next);
    taken[next] = true;
    for (std::size_t j = 0; j < cameras.size(); ++j)
      apart[j] = taken[j] ? -1 : std::min(apart[j], (to.unit[j] - to.unit[next]).squaredNorm());
    next = std::max_element(apart.begin(), apart.end()) - apart.begin();
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace sheen
