// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/exchange/charts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>
#include <unordered_map>
#include <utility>

#include "reconstructor/exchange/flat_triangle.h"

namespace sheen {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr std::uint32_t kNone = ~0u;
constexpr float kGrowsTo = 0.643f;  ///< cosine to the mean normal of what a chart has: 50 degrees
constexpr float kFaces = 0.342f;    ///< cosine to the side that it is seen from: 70 degrees
/// In which a second sheet is looked for: along the longer edge of a chart, some for each of its triangles.
constexpr float kCellsPerTriangle = 16;
constexpr int kFewestCells = 32, kMostCells = 1024;
constexpr float kInside = 1e-3f;  ///< barycentric: what two triangles share is no sheet over another

using Neighbours = std::vector<std::array<std::uint32_t, 3>>;  ///< per triangle across its edges

/// One number for all vertices at one place: meshes come with vertices for each triangle, too.
std::vector<std::uint32_t> places_of(const Mesh& mesh) {
  std::map<std::array<float, 3>, std::uint32_t> first;
  std::vector<std::uint32_t> places;
  places.reserve(mesh.vertices.size());
  for (const Vector3f& v : mesh.vertices)
    places.push_back(first.try_emplace({v.x(), v.y(), v.z()}, static_cast<std::uint32_t>(first.size())).first->second);
  return places;
}

/// Across edges that exactly two triangles share, in opposite directions.
Neighbours neighbours_of(const Mesh& mesh) {
  const std::vector<std::uint32_t> places = places_of(mesh);
  const auto place = [&](std::uint32_t t, int corner) { return places[mesh.triangles[t][corner % 3]]; };
  Neighbours neighbours(mesh.triangles.size(), {kNone, kNone, kNone});
  std::unordered_map<std::uint64_t, std::vector<std::pair<std::uint32_t, int>>> edges;
  edges.reserve(2 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      const std::uint64_t a = place(t, c), b = place(t, c + 1);
      edges[std::min(a, b) << 32 | std::max(a, b)].emplace_back(t, c);
    }
  for (const auto& [edge, sides] : edges) {
    if (sides.size() != 2) continue;
    const auto& [t, c] = sides[0];
    const auto& [s, d] = sides[1];
    if (place(t, c) == place(s, d)) continue;  // turned over
    neighbours[t][c] = s;
    neighbours[s][d] = t;
  }
  return neighbours;
}

float cosine(const Vector3f& a, const Vector3f& b) {
  return a.normalized().dot(b.normalized());
}

Eigen::Matrix<float, 2, 3> plane_across(const Vector3f& normal) {
  Eigen::Matrix<float, 2, 3> plane;
  const Vector3f x = normal.unitOrthogonal();
  plane << x.transpose(), normal.cross(x).transpose();
  return plane;
}

/// Grows charts over triangles that none has yet.
class ChartCutter {
 public:
  explicit ChartCutter(const Mesh& mesh)
      : mesh_(mesh), neighbours_(neighbours_of(mesh)), marks_(mesh.triangles.size(), kFree) {
    normals_.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) normals_.push_back(mesh.area_normal(t));
  }

  std::vector<Chart> cut() {
    std::vector<Chart> charts;
    for (std::uint32_t seed = 0; seed < mesh_.triangles.size(); ++seed)
      if (marks_[seed] != kTaken) charts.push_back(grown_from(seed));
    return charts;
  }

 private:
  enum Mark : std::uint8_t { kFree, kWanted, kTaken };

  Chart grown_from(std::uint32_t seed) {
    std::vector<std::uint32_t> members = flattest_round(seed);
    for (const std::uint32_t t : members) marks_[t] = kFree;
    const Eigen::Matrix<float, 2, 3> plane = plane_across(side_of(members));
    for (const std::uint32_t t : one_sheet(members, plane)) marks_[t] = kWanted;
    std::vector<std::uint32_t> piece = connected(seed);
    for (const std::uint32_t t : members) marks_[t] = kFree;
    for (const std::uint32_t t : piece) marks_[t] = kTaken;
    return {std::move(piece), plane};
  }

  /// Takes the neighbour that bends least, again and again.
  std::vector<std::uint32_t> flattest_round(std::uint32_t seed) {
    Vector3f sum = Vector3f::Zero();
    const auto bend = [&](std::uint32_t t) { return cosine(normals_[t], sum); };
    std::vector<std::uint32_t> members;
    std::priority_queue<std::pair<float, std::uint32_t>> edge;
    edge.emplace(1.0f, seed);
    while (!edge.empty()) {
      const std::uint32_t t = edge.top().second;
      edge.pop();
      if (marks_[t] != kFree || (t != seed && bend(t) < kGrowsTo)) continue;
      marks_[t] = kWanted;
      members.push_back(t);
      sum += normals_[t];
      for (const std::uint32_t next : neighbours_[t])
        if (next != kNone && marks_[next] == kFree) edge.emplace(bend(next), next);
    }
    return members;
  }

  /// Their mean normal; that of the first, the seed, where it would not face it.
  Vector3f side_of(const std::vector<std::uint32_t>& members) const {
    Vector3f sum = Vector3f::Zero();
    for (const std::uint32_t t : members) sum += normals_[t];
    const Vector3f& seed = normals_[members.front()];
    return (cosine(seed, sum) < kFaces ? seed : sum).normalized();
  }

  /// Those that face the side and lie over no earlier one. The seed always does.
  std::vector<std::uint32_t> one_sheet(const std::vector<std::uint32_t>& members,
                                       const Eigen::Matrix<float, 2, 3>& plane) const {
    const Vector3f side = plane.row(0).transpose().cross(plane.row(1).transpose());
    Eigen::AlignedBox2f box;
    for (const std::uint32_t t : members)
      for (int c = 0; c < 3; ++c) box.extend(Vector2f(plane * mesh_.corner(t, c)));
    const int cells_across = std::clamp(
        static_cast<int>(kCellsPerTriangle * std::sqrt(static_cast<float>(members.size()))), kFewestCells, kMostCells);
    const float cell = std::max(box.sizes().maxCoeff(), 1e-30f) / static_cast<float>(cells_across);
    std::vector<bool> covered(static_cast<std::size_t>(cells_across) * cells_across);
    std::vector<std::uint32_t> sheet;
    std::vector<std::size_t> cells;
    for (const std::uint32_t t : members) {
      if (cosine(normals_[t], side) < kFaces) continue;
      FlatTriangle flat;
      for (int c = 0; c < 3; ++c) flat.corners[c] = (plane * mesh_.corner(t, c) - box.min()) / cell;
      cells.clear();
      flat.for_each_pixel(cells_across, cells_across, 0, [&](int x, int y, const Vector3f& weights) {
        if (weights.minCoeff() > kInside) cells.push_back(static_cast<std::size_t>(y) * cells_across + x);
      });
      if (std::ranges::any_of(cells, [&](std::size_t at) { return covered[at]; })) continue;
      for (const std::size_t at : cells) covered[at] = true;
      sheet.push_back(t);
    }
    return sheet;
  }

  /// Of the triangles that are wanted those that hang together with the seed.
  std::vector<std::uint32_t> connected(std::uint32_t seed) {
    std::vector<std::uint32_t> piece{seed};
    marks_[seed] = kFree;
    for (std::size_t i = 0; i < piece.size(); ++i)
      for (const std::uint32_t next : neighbours_[piece[i]])
        if (next != kNone && marks_[next] == kWanted) {
          marks_[next] = kFree;
          piece.push_back(next);
        }
    return piece;
  }

  const Mesh& mesh_;
  const Neighbours neighbours_;
  std::vector<Vector3f> normals_;
  std::vector<Mark> marks_;
};

}  // namespace

std::vector<Chart> cut_into_charts(const Mesh& mesh) {
  return ChartCutter(mesh).cut();
}

}  // namespace sheen
