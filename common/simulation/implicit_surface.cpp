// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/implicit_surface.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/base/errors.h"

namespace sheen {
namespace {

using Quad = std::array<std::uint32_t, 4>;
constexpr int kRelaxations = 40;
constexpr double kStep = 2e-5;  // metres, for differences

struct Grid {
  Eigen::Vector3d origin;
  double cell;
  Eigen::Array3i points;
  std::vector<double> value;

  std::size_t index(int x, int y, int z) const { return (std::size_t(z) * points.y() + y) * points.x() + x; }
  Eigen::Vector3d position(int x, int y, int z) const { return origin + cell * Eigen::Vector3d(x, y, z); }
};

Grid sample(const ImplicitFunction& distance, const Eigen::Vector3d& box_min, const Eigen::Vector3d& box_max,
            double cell) {
  Grid grid{.origin = box_min, .cell = cell, .points = {}, .value = {}};
  grid.points = ((box_max - box_min).array() / cell).ceil().cast<int>() + 1;
  grid.value.resize(grid.points.cast<std::size_t>().prod());
  tbb::parallel_for(0, grid.points.z(), [&](int z) {
    for (int y = 0; y < grid.points.y(); ++y)
      for (int x = 0; x < grid.points.x(); ++x) {
        const double d = distance(grid.position(x, y, z));
        const bool border = x == 0 || y == 0 || z == 0 || x == grid.points.x() - 1 || y == grid.points.y() - 1 ||
                            z == grid.points.z() - 1;
        if (border && d <= 0) throw ConfigError("the implicit surface reaches the sides of its box; enlarge the box");
        grid.value[grid.index(x, y, z)] = d;
      }
  });
  return grid;
}

/// One vertex per crossed cell, at the mean of the crossings of its edges; `vertex_of_cell` holds its index or -1.
std::vector<Eigen::Vector3d> place_vertices(const Grid& grid, std::vector<std::int32_t>& vertex_of_cell) {
  std::vector<Eigen::Vector3d> vertices;
  vertex_of_cell.assign(grid.value.size(), -1);
  for (int z = 0; z + 1 < grid.points.z(); ++z)
    for (int y = 0; y + 1 < grid.points.y(); ++y)
      for (int x = 0; x + 1 < grid.points.x(); ++x) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        int crossings = 0;
        for (int axis = 0; axis < 3; ++axis)
          for (int k = 0; k < 4; ++k) {
            Eigen::Array3i a(x, y, z);
            a[(axis + 1) % 3] += k & 1;
            a[(axis + 2) % 3] += k >> 1;
            Eigen::Array3i b = a;
            b[axis] += 1;
            const double da = grid.value[grid.index(a.x(), a.y(), a.z())];
            const double db = grid.value[grid.index(b.x(), b.y(), b.z())];
            if ((da < 0) == (db < 0)) continue;
            Eigen::Vector3d at = a.cast<double>().matrix();
            at[axis] += da / (da - db);
            sum += at;
            ++crossings;
          }
        if (crossings == 0) continue;
        vertex_of_cell[grid.index(x, y, z)] = static_cast<std::int32_t>(vertices.size());
        vertices.push_back(grid.origin + grid.cell * sum / crossings);
      }
  return vertices;
}

/// One quad a crossed grid edge, through the four cells round it, wound outward.
std::vector<Quad> connect(const Grid& grid, const std::vector<std::int32_t>& vertex_of_cell) {
  std::vector<Quad> quads;
  for (int z = 0; z + 1 < grid.points.z(); ++z)
    for (int y = 0; y + 1 < grid.points.y(); ++y)
      for (int x = 0; x + 1 < grid.points.x(); ++x)
        for (int axis = 0; axis < 3; ++axis) {
          const Eigen::Array3i a(x, y, z);
          Eigen::Array3i b = a;
          b[axis] += 1;
          const bool inside_a = grid.value[grid.index(x, y, z)] < 0;
          const bool inside_b = grid.value[grid.index(b.x(), b.y(), b.z())] < 0;
          if (inside_a == inside_b) continue;
          const int p = (axis + 1) % 3, q = (axis + 2) % 3;
          const auto cell = [&](int dp, int dq) {
            Eigen::Array3i c = a;
            c[p] -= dp;
            c[q] -= dq;
            return static_cast<std::uint32_t>(vertex_of_cell[grid.index(c.x(), c.y(), c.z())]);
          };
          // Counter-clockwise about +axis, so outward where the inside lies below.
          Quad quad{cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)};
          if (!inside_a) std::swap(quad[1], quad[3]);
          quads.push_back(quad);
        }
  return quads;
}

std::vector<Triangle> split(const std::vector<Quad>& quads, const std::vector<Eigen::Vector3d>& v) {
  std::vector<Triangle> triangles;
  for (const Quad& q : quads) {
    if ((v[q[0]] - v[q[2]]).norm() <= (v[q[1]] - v[q[3]]).norm()) {
      triangles.push_back({q[0], q[1], q[2]});
      triangles.push_back({q[0], q[2], q[3]});
    } else {
      triangles.push_back({q[0], q[1], q[3]});
      triangles.push_back({q[1], q[2], q[3]});
    }
  }
  return triangles;
}

Eigen::Vector3d gradient(const ImplicitFunction& distance, const Eigen::Vector3d& p) {
  Eigen::Vector3d g;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
    g[axis] = (distance(p + step) - distance(p - step)) / (2 * kStep);
  }
  return g;
}

/// Moves each vertex towards the mean of its neighbours within the tangent plane, then back onto the surface.
void relax(const ImplicitFunction& distance, const std::vector<Triangle>& triangles, double cell,
           std::vector<Eigen::Vector3d>& vertices) {
  std::vector<Eigen::Vector3d> sum(vertices.size(), Eigen::Vector3d::Zero());
  std::vector<int> count(vertices.size(), 0);
  for (const Triangle& t : triangles)
    for (int c = 0; c < 3; ++c) {  // each edge is met once from either side
      sum[t[c]] += vertices[t[(c + 1) % 3]];
      ++count[t[c]];
    }
  tbb::parallel_for(std::size_t{0}, vertices.size(), [&](std::size_t i) {
    Eigen::Vector3d& p = vertices[i];
    const Eigen::Vector3d g = gradient(distance, p), n = g.normalized();
    const Eigen::Vector3d pull = sum[i] / count[i] - p;
    p += 0.7 * (pull - n * n.dot(pull));
    const double off = distance(p);
    p -= n * std::clamp(off / std::max(g.norm(), 0.3), -cell / 2, cell / 2);
  });
}

/// Flips edges whose opposite angles sum to more than pi (Delaunay), which keeps triangles from growing thin.
void flip_edges(const std::vector<Eigen::Vector3d>& v, std::vector<Triangle>& triangles) {
  struct Side {
    std::uint32_t a, b;  // ends in ascending order
    std::uint32_t triangle;
    std::uint8_t corner;  // opposite the edge
  };
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint8_t c = 0; c < 3; ++c) {
      const std::uint32_t a = triangles[t][(c + 1) % 3], b = triangles[t][(c + 2) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), t, c});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& l, const Side& r) {
    return std::tie(l.a, l.b, l.triangle) < std::tie(r.a, r.b, r.triangle);
  });
  const auto has_edge = [&](std::uint32_t a, std::uint32_t b) {
    const Side key{std::min(a, b), std::max(a, b), 0, 0};
    const auto it = std::lower_bound(sides.begin(), sides.end(), key, [](const Side& l, const Side& r) {
      return std::tie(l.a, l.b, l.triangle) < std::tie(r.a, r.b, r.triangle);
    });
    return it != sides.end() && it->a == key.a && it->b == key.b;
  };
  const auto angle = [&](std::uint32_t at, std::uint32_t p, std::uint32_t q) {
    const Eigen::Vector3d e = v[p] - v[at], f = v[q] - v[at];
    return std::atan2(e.cross(f).norm(), e.dot(f));
  };
  std::vector<bool> touched(triangles.size(), false);
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const Side &s = sides[i], &r = sides[i + 1];
    if (s.a != r.a || s.b != r.b || touched[s.triangle] || touched[r.triangle]) continue;
    const Triangle t = triangles[s.triangle];
    const std::uint32_t p = t[s.corner], from = t[(s.corner + 1) % 3], to = t[(s.corner + 2) % 3];
    const std::uint32_t q = triangles[r.triangle][r.corner];
    if (angle(p, from, to) + angle(q, from, to) <= M_PI + 1e-6 || has_edge(p, q)) continue;
    const Eigen::Vector3d n = (v[from] - v[p]).cross(v[to] - v[p]);
    if ((v[from] - v[p]).cross(v[q] - v[p]).dot(n) <= 0 || (v[q] - v[p]).cross(v[to] - v[p]).dot(n) <= 0) continue;
    triangles[s.triangle] = {p, from, q};
    triangles[r.triangle] = {p, q, to};
    touched[s.triangle] = touched[r.triangle] = true;
  }
}

}  // namespace

Eigen::Vector3d implicit_normal(const ImplicitFunction& distance, const Eigen::Vector3d& point) {
  return gradient(distance, point).normalized();
}

Mesh mesh_implicit_surface(const ImplicitFunction& distance, const Eigen::Vector3d& box_min,
                           const Eigen::Vector3d& box_max, double cell) {
  const Grid grid = sample(distance, box_min, box_max, cell);
  std::vector<std::int32_t> vertex_of_cell;
  std::vector<Eigen::Vector3d> vertices = place_vertices(grid, vertex_of_cell);
  std::vector<Triangle> triangles = split(connect(grid, vertex_of_cell), vertices);
  for (int i = 0; i < kRelaxations; ++i) {
    relax(distance, triangles, cell, vertices);
    flip_edges(vertices, triangles);
  }
  Mesh mesh;
  mesh.triangles = std::move(triangles);
  for (const Eigen::Vector3d& p : vertices) mesh.vertices.push_back(p.cast<float>());
  return mesh;
}

}  // namespace sheen
