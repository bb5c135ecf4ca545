// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/exchange/texture_atlas.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>

#include "common/base/errors.h"
#include "reconstructor/exchange/charts.h"

namespace sheen {
namespace {

using Eigen::Vector2f;

constexpr int kTurns = 18;       ///< of a right angle, to find how a chart takes the least room
constexpr int kScales = 24;      ///< bisections of the scale
constexpr float kLeast = 1e-4f;  ///< of the scale at which the charts would fill the texture

/// A chart laid flat, in the mesh's unit, its box at zero and no higher than wide.
struct FlatChart {
  std::vector<FlatTriangle> triangles;  ///< in the order of the chart's
  Vector2f size;
};

FlatChart laid_flat(const Mesh& mesh, const Chart& chart) {
  FlatChart best;
  for (int turn = 0; turn < kTurns; ++turn) {
    const Eigen::Rotation2Df rotation(static_cast<float>(turn) / kTurns * std::numbers::pi_v<float> / 2);
    const Eigen::Matrix<float, 2, 3> plane = rotation.toRotationMatrix() * chart.plane;
    Eigen::AlignedBox2f box;
    for (const std::uint32_t t : chart.triangles)
      for (int c = 0; c < 3; ++c) box.extend(Vector2f(plane * mesh.corner(t, c)));
    if (turn > 0 && box.sizes().prod() >= best.size.prod()) continue;
    best = {.triangles = {}, .size = box.sizes()};
    for (const std::uint32_t t : chart.triangles) {
      FlatTriangle flat;
      for (int c = 0; c < 3; ++c) {
        const Vector2f at = plane * mesh.corner(t, c) - box.min();
        flat.corners[c] = {at.x(), box.sizes().y() - at.y()};  // down, as pictures run
      }
      best.triangles.push_back(flat);
    }
  }
  if (best.size.y() > best.size.x()) {  // a quarter turn
    for (FlatTriangle& flat : best.triangles)
      for (Vector2f& corner : flat.corners) corner = Vector2f(best.size.y() - corner.y(), corner.x());
    std::swap(best.size.x(), best.size.y());
  }
  return best;
}

/// Upper left corners of the charts, gutters included, row by row, the highest first; none where they do not fit.
std::optional<std::vector<Eigen::Vector2i>> in_rows(const std::vector<FlatChart>& charts,
                                                    const std::vector<std::size_t>& highest_first, float scale,
                                                    int side) {
  std::vector<Eigen::Vector2i> places(charts.size());
  int x = 0, y = 0, row = 0;
  for (const std::size_t i : highest_first) {
    const Vector2f size = scale * charts[i].size;
    if (!(size.maxCoeff() < static_cast<float>(side))) return std::nullopt;
    const int width = static_cast<int>(std::ceil(size.x())) + 2 * kGutter;
    const int height = static_cast<int>(std::ceil(size.y())) + 2 * kGutter;
    if (x > 0 && x + width > side) {
      y += row;
      x = row = 0;
    }
    if (width > side || y + height > side) return std::nullopt;
    places[i] = {x, y};
    x += width;
    row = std::max(row, height);
  }
  return places;
}

}  // namespace

TextureAtlas texture_atlas(const Mesh& mesh, int side) {
  const std::vector<Chart> charts = cut_into_charts(mesh);
  std::vector<FlatChart> flat;
  flat.reserve(charts.size());
  float area = 0;
  for (const Chart& chart : charts) area += flat.emplace_back(laid_flat(mesh, chart)).size.prod();
  std::vector<std::size_t> highest_first(flat.size());
  std::iota(highest_first.begin(), highest_first.end(), std::size_t{0});
  std::ranges::stable_sort(highest_first,
                           [&](std::size_t a, std::size_t b) { return flat[a].size.y() > flat[b].size.y(); });

  float too_large = static_cast<float>(side) / std::sqrt(area), fits = kLeast * too_large;
  auto places = in_rows(flat, highest_first, fits, side);
  if (!places)
    throw ConfigError("the mesh has " + std::to_string(charts.size()) + " pieces, too many for a texture of " +
                      std::to_string(side) + " x " + std::to_string(side) + "; join its vertices, or simplify it");
  for (int i = 0; i < kScales; ++i) {
    const float scale = std::sqrt(fits * too_large);
    if (auto tried = in_rows(flat, highest_first, scale, side)) {
      places = std::move(tried);
      fits = scale;
    } else {
      too_large = scale;
    }
  }

  TextureAtlas atlas{.side = side,
                     .triangles = std::vector<FlatTriangle>(mesh.triangles.size()),
                     .chart = std::vector<std::uint32_t>(mesh.triangles.size())};
  for (std::size_t i = 0; i < charts.size(); ++i) {
    const Vector2f corner = (*places)[i].cast<float>().array() + static_cast<float>(kGutter);
    for (std::size_t k = 0; k < charts[i].triangles.size(); ++k) {
      const std::uint32_t t = charts[i].triangles[k];
      atlas.chart[t] = static_cast<std::uint32_t>(i);
      for (int c = 0; c < 3; ++c) atlas.triangles[t].corners[c] = fits * flat[i].triangles[k].corners[c] + corner;
    }
  }
  return atlas;
}

}  // namespace sheen
