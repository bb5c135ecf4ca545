// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/luminaires.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "reconstructor/render/smooth_path.h"

namespace sheen {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
constexpr double kPi = std::numbers::pi;
// A place that is further from the nearest light than this many of the usual gaps is not interpolated but guessed.
constexpr double kReach = 1.5;
constexpr int kFewestRows = 24, kMostRows = 96;
constexpr int kCellsPerGap = 3;

/// Directions to the lights from the origin, and the usual angle between one and the next.
struct KnownDirections {
  std::vector<Vector3d> directions;
  double gap = kPi;

  explicit KnownDirections(std::span<const LightState> lights) {
    for (const LightState& light : lights) directions.push_back(light.position.normalized());
    std::vector<double> gaps;
    for (std::size_t i = 0; i < directions.size(); ++i) {
      double nearest = -1;
      for (std::size_t j = 0; j < directions.size(); ++j)
        if (j != i) nearest = std::max(nearest, directions[i].dot(directions[j]));
      gaps.push_back(std::acos(std::clamp(nearest, -1.0, 1.0)));
    }
    if (gaps.empty()) return;
    gap = median(gaps);
  }
  bool reach(const Vector3d& direction) const {
    const double least = std::cos(std::min(kReach * gap, kPi));
    return std::any_of(directions.begin(), directions.end(),
                       [&](const Vector3d& known) { return known.dot(direction) >= least; });
  }
};

/// Light from a part of the sphere.
struct Cell {
  Vector3d direction = Vector3d::Zero();  ///< weighted by its light
  Vector3d rgb = Vector3d::Zero();        ///< radiance times solid angle
};

}  // namespace

std::vector<LightState> lights_of(const AreaLuminaire& lamp, LightKind kind, int per_side) {
  const Vector3d normal = lamp.half_u.cross(lamp.half_v).normalized();
  // Of a small lamp what arrives at the origin: its cosine over the square of its distance.
  const auto strength = [&](const Vector3d& place) {
    return std::max(0.0, -normal.dot(place)) / std::pow(place.norm(), 3);
  };
  std::vector<LightState> lights;
  for (int i = 0; i < per_side; ++i)
    for (int j = 0; j < per_side; ++j) {
      const auto offset = [&](int k) { return (2 * k + 1.0) / per_side - 1; };
      const Vector3d place = lamp.centre + offset(i) * lamp.half_u + offset(j) * lamp.half_v;
      double fraction = strength(place) / (strength(lamp.centre) * per_side * per_side);
      // A point light's picture has its distance in it already.
      if (kind == LightKind::kPoint) fraction *= place.squaredNorm() / lamp.centre.squaredNorm();
      if (fraction > 0)
        lights.push_back(
            {kind, kind == LightKind::kPoint ? place : place.normalized(), static_cast<float>(fraction) * lamp.rgb});
    }
  return lights;
}

EnvironmentLights lights_of(const ImageF& environment, std::span<const LightState> known) {
  const KnownDirections near(known);
  const int rows = std::clamp(static_cast<int>(std::lround(kCellsPerGap * kPi / near.gap)), kFewestRows, kMostRows);
  const auto columns = [&](int row) {
    return std::max(1, static_cast<int>(std::lround(2 * rows * std::sin(kPi * (row + 0.5) / rows))));
  };
  std::vector<std::vector<Cell>> cells(static_cast<std::size_t>(rows));
  for (int row = 0; row < rows; ++row)
    cells[static_cast<std::size_t>(row)].resize(static_cast<std::size_t>(columns(row)));
  const int w = environment.width(), h = environment.height();
  for (int y = 0; y < h; ++y) {
    const double polar = kPi * (y + 0.5) / h, solid = std::sin(polar) * (kPi / h) * (2 * kPi / w);
    auto& row = cells[static_cast<std::size_t>(std::min(rows - 1, rows * y / h))];
    for (int x = 0; x < w; ++x) {
      const double longitude = kPi - 2 * kPi * (x + 0.5) / w;
      const Vector3d direction(std::sin(longitude) * std::sin(polar), std::cos(polar),
                               std::cos(longitude) * std::sin(polar));
      const Vector3d light = solid * Eigen::Map<const Vector3f>(environment.pixel(x, y)).cast<double>().cwiseMax(0);
      Cell& cell = row[static_cast<std::size_t>(x) * row.size() / static_cast<std::size_t>(w)];
      cell.rgb += light;
      cell.direction += light.sum() * direction;
    }
  }
  EnvironmentLights found;
  double all = 0;
  for (const auto& row : cells)
    for (const Cell& cell : row) {
      if (!(cell.rgb.sum() > 0) || !cell.direction.allFinite() || !(cell.direction.norm() > 0)) continue;
      all += cell.rgb.sum();
      const Vector3d direction = cell.direction.normalized();
      if (near.reach(direction))
        // A light without a colour is refused by models; darkness in one is next to nothing instead.
        found.lights.push_back({LightKind::kDirectional, direction, (cell.rgb / kPi).cast<float>().cwiseMax(1e-20f)});
      else
        found.left_out += cell.rgb.sum();
    }
  if (found.lights.empty())
    throw ConfigError("the environment is dark, or all of its light comes from where the model's images had no light");
  found.left_out /= all;
  return found;
}

std::vector<LightState> light_path(std::span<const LightState> keys, int frames) {
  std::vector<Vector3d> places;
  for (const LightState& key : keys) places.push_back(key.position);
  const std::vector<Vector3d> smooth = smooth_path(places, frames, false);
  std::vector<LightState> path;
  const auto last = static_cast<double>(keys.size() - 1);
  for (int i = 0; i < frames; ++i) {
    const double at = last * i / (frames - 1);
    const auto k = std::min(static_cast<std::size_t>(at), keys.size() - 2);
    const auto t = static_cast<float>(at - static_cast<double>(k));
    LightState light = keys[k];
    light.position = smooth[static_cast<std::size_t>(i)];
    light.rgb = (1 - t) * keys[k].rgb + t * keys[k + 1].rgb;
    if (light.kind == LightKind::kDirectional) light.position.normalize();
    path.push_back(light);
  }
  return path;
}

}  // namespace sheen
