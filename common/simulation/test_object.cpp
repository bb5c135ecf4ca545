// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/test_object.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "common/base/errors.h"
#include "common/simulation/bronze.h"
#include "common/simulation/glaze.h"
#include "common/simulation/implicit_surface.h"
#include "common/simulation/lacquer.h"

namespace sheen {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kScale = 1.06e-3;  // metres a unit of the shape
constexpr double kCell = 0.00344;   // metres; gives kTriangles of them, about
constexpr double kTriangles = 12e3;

/// Union of two bodies with a fillet of about `r` between them.
double blend_union(double a, double b, double r) {
  const double h = std::max(r - std::abs(a - b), 0.0) / r;
  return std::min(a, b) - h * h * r / 4;
}

double ellipsoid(const Vec& p, const Vec& radii) {
  const double k0 = p.cwiseQuotient(radii).norm(), k1 = p.cwiseQuotient(radii.cwiseAbs2()).norm();
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -radii.minCoeff();
}

/// Ring of radius `major` round the z axis.
double ring(const Vec& p, double major, double minor) {
  return std::hypot(std::hypot(p.x(), p.y()) - major, p.z()) - minor;
}

/// Flat cylinder round the z axis whose edges are rounded off.
double disc(const Vec& p, double radius, double half_height, double rounding) {
  const Eigen::Vector2d q(std::hypot(p.x(), p.y()) - radius + rounding, std::abs(p.z()) - half_height + rounding);
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - rounding;
}

/// Round tube along a cubic Bezier curve, its radius going from `r0` to `r1`.
class Tube {
 public:
  Tube(const Vec& a, const Vec& b, const Vec& c, const Vec& d, double r0, double r1) : r0_(r0), r1_(r1) {
    for (int i = 0; i <= kSegments; ++i) {
      const double t = double(i) / kSegments, s = 1 - t;
      points_[i] = s * s * s * a + 3 * s * s * t * b + 3 * s * t * t * c + t * t * t * d;
    }
  }
  double operator()(const Vec& p) const {
    double best = 1e9;
    for (int i = 0; i < kSegments; ++i) {
      const Vec along = points_[i + 1] - points_[i], from = p - points_[i];
      const double t = std::clamp(from.dot(along) / along.squaredNorm(), 0.0, 1.0);
      best = std::min(best, (from - t * along).norm() - (r0_ + (r1_ - r0_) * (i + t) / kSegments));
    }
    return best;
  }

 private:
  static constexpr int kSegments = 32;
  std::array<Vec, kSegments + 1> points_;
  double r0_, r1_;
};

/// In units of the shape, which are about millimetres.
double teapot(const Vec& p) {
  static const Tube spout({36, 0, 30}, {74, 0, 26}, {66, 0, 74}, {88, 0, 90}, 16, 7.5);
  static const Tube handle({-38, 0, 72}, {-92, 0, 100}, {-112, 0, 34}, {-42, 0, 24}, 7.5, 6.5);
  const double azimuth = std::atan2(p.y(), p.x());
  const double ribs = 1.7 * std::cos(12 * azimuth) * std::exp(-std::pow((p.z() - 46) / 26, 2)) *
                      std::min(1.0, std::hypot(p.x(), p.y()) / 25);
  double d = ellipsoid(p - Vec(0, 0, 46), {53, 53, 39}) - ribs;
  const double foot = disc(p - Vec(0, 0, 6.4), 30, 6, 4);
  d = blend_union(d, foot, 7);
  d = blend_union(d, ring(p - Vec(0, 0, 79), 29, 3.6), 3);                  // the lid's seat
  d = blend_union(d, ellipsoid(p - Vec(0, 0, 83), {25, 25, 11}), 3);        // lid
  d = blend_union(d, ellipsoid(p - Vec(0, 0, 103.5), {9.5, 9.5, 8.5}), 8);  // knob
  d = blend_union(d, spout(p), 9);
  d = blend_union(d, handle(p), 8);
  return d;
}

double teapot_m(const Vec& p) {
  return teapot(p / kScale) * kScale;
}

Mesh mesh_of_cells(double cell_m) {
  return mesh_implicit_surface(teapot_m, {-0.122, -0.0775, -0.010}, {0.122, 0.0775, 0.131}, cell_m);
}

}  // namespace

Mesh make_demo_mesh(int triangles) {
  return mesh_of_cells(kCell * std::sqrt(kTriangles / triangles));
}

TestObject make_demo_object() {
  TestObject object{.name = "demo", .mesh = mesh_of_cells(kCell), .normals = {}, .material = Glaze{}};
  for (const Eigen::Vector3f& v : object.mesh.vertices)
    object.normals.push_back(implicit_normal(teapot_m, v.cast<double>()).cast<float>());
  return object;
}

TestObject make_bronze_object() {
  TestObject object = make_demo_object();
  object.name = "bronze";
  object.material = Bronze{};
  return object;
}

TestObject make_lacquer_object() {
  TestObject object = make_demo_object();
  object.name = "lacquer";
  object.material = Lacquer{};
  return object;
}

TestObject make_sphere(const Material& material, double radius_m, const Eigen::Vector3d& centre, int subdivisions) {
  const float g = (1 + std::sqrt(5.0f)) / 2;
  std::vector<Eigen::Vector3f> directions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                             {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (auto& d : directions) d.normalize();
  std::vector<Triangle> triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                     {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                     {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                     {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < subdivisions; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
    const auto between = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, is_new] = middle.try_emplace(std::minmax(a, b), directions.size());
      if (is_new) directions.push_back((directions[a] + directions[b]).normalized());
      return it->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::uint32_t ab = between(a, b), bc = between(b, c), ca = between(c, a);
      for (const Triangle& t : {Triangle{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}}) finer.push_back(t);
    }
    triangles = std::move(finer);
  }
  TestObject object{.name = "sphere", .mesh = {}, .normals = directions, .material = {}};
  object.mesh.triangles = std::move(triangles);
  for (const auto& d : directions) object.mesh.vertices.push_back((centre + radius_m * d.cast<double>()).cast<float>());
  object.material = [material](const Eigen::Vector3f&) { return material; };
  return object;
}

TestObject make_demo_sphere() {
  constexpr double kRadius = 0.045;
  TestObject object = make_sphere({}, kRadius, {0, 0, kRadius + 0.0004}, 4);
  object.material = Glaze{.top_height = 0.09f, .band_heights = {0.020f, 0.045f, 0.070f}};
  return object;
}

TestObject make_test_object(const std::string& name) {
  if (name == "demo") return make_demo_object();
  if (name == "bronze") return make_bronze_object();
  if (name == "lacquer") return make_lacquer_object();
  if (name == "sphere") return make_demo_sphere();
  throw ConfigError("there is no object \"" + name + "\"; use \"demo\", \"bronze\", \"lacquer\" or \"sphere\"");
}

}  // namespace sheen
