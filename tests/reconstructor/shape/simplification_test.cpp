// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/simplification.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "reconstructor/shape/closed_surface.h"
#include "tests/reconstructor/shape/analytic_field.h"
#include "tests/reconstructor/shape/closed_mesh.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

template <typename Distance>
Mesh surface_of(int points, const Distance& distance) {
  return closed_surface(field_of(centred_lattice(points, 1), 3, distance)).mesh;
}

Vector3f middle(const Mesh& mesh, std::size_t t) {
  return (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
}

/// Triangles per area, of those whose middle is in a part.
template <typename Part>
double density(const Mesh& mesh, const Part& part) {
  double triangles = 0, area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!part(middle(mesh, t))) continue;
    ++triangles;
    area += mesh.area_normal(t).norm() / 2;
  }
  return triangles / area;
}

/// A cube from -1 to 1 whose sides are cut into 2 * cells^2 triangles each.
Mesh cube_mesh(int cells) {
  Mesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> number;
  const auto vertex = [&](int axis, int side, int u, int v) {
    std::array<int, 3> at{};
    at[axis] = side * cells, at[(axis + 1) % 3] = u, at[(axis + 2) % 3] = v;
    const auto [it, fresh] = number.try_emplace(at, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (fresh) mesh.vertices.push_back(Vector3f(at[0], at[1], at[2]) * 2 / cells - Vector3f::Ones());
    return it->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {0, 1})
      for (int u = 0; u < cells; ++u)
        for (int v = 0; v < cells; ++v) {
          std::uint32_t a = vertex(axis, side, u, v), b = vertex(axis, side, u + 1, v),
                        c = vertex(axis, side, u + 1, v + 1), d = vertex(axis, side, u, v + 1);
          if (side == 0) std::swap(b, d);
          mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
        }
  return mesh;
}

TEST(Simplification, OfASphereStaysASphere) {
  const Mesh mesh = surface_of(64, [](const Vector3d& at) { return at.norm() - 0.8; });
  const Mesh simple = simplified(mesh, 2000);
  expect_closed(simple);
  EXPECT_EQ(simple.triangles.size(), 2000u);
  EXPECT_EQ(euler_characteristic(simple), 2);
  // Equal triangles of this number have a middle this far below the sphere, if their corners are on it.
  const double side2 = 4 * M_PI * 0.64 / 2000 * 4 / std::sqrt(3), sagitta = side2 / 3 / (2 * 0.8);
  for (std::size_t t = 0; t < simple.triangles.size(); ++t) {
    EXPECT_NEAR(middle(simple, t).norm(), 0.8, 2 * sagitta);
    EXPECT_NEAR(simple.corner(t, 0).norm(), 0.8, 2 * sagitta);
  }
  const double volume = 4.0 / 3 * M_PI * std::pow(0.8, 3);
  EXPECT_NEAR(diagnose(simple).signed_volume, volume, 0.003 * volume);
}

TEST(Simplification, ARingKeepsItsHole) {
  const Mesh mesh =
      surface_of(60, [](const Vector3d& at) { return std::hypot(std::hypot(at.x(), at.y()) - 0.6, at.z()) - 0.2; });
  for (const std::size_t triangles : {1500, 300, 20}) {
    const Mesh simple = simplified(mesh, triangles);
    expect_closed(simple);
    EXPECT_EQ(euler_characteristic(simple), 0);
    if (triangles >= 300) EXPECT_EQ(simple.triangles.size(), triangles);
  }
}

TEST(Simplification, ACubeKeepsItsCornersAndEdges) {
  const Mesh simple = simplified(cube_mesh(20), 60);
  expect_closed(simple);
  EXPECT_EQ(simple.triangles.size(), 60u);
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3f at(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    float nearest = 9;
    for (const Vector3f& vertex : simple.vertices) nearest = std::min(nearest, (vertex - at).norm());
    EXPECT_LT(nearest, 0.01f) << at.transpose();
  }
  EXPECT_NEAR(diagnose(simple).signed_volume, 8, 0.04);
}

TEST(Simplification, FlatPartsGetFewTriangles) {
  const Vector3d half(0.9, 0.9, 0.3), centre(0, 0, 0.3);
  const Mesh simple = simplified(
      surface_of(
          80,
          [&](const Vector3d& at) { return std::min((at.cwiseAbs() - half).maxCoeff(), (at - centre).norm() - 0.4); }),
      3000);
  expect_closed(simple);
  const double flat = density(simple, [](const Vector3f& at) { return at.z() < -0.28f && at.head<2>().norm() < 0.8f; });
  const double round = density(simple, [](const Vector3f& at) { return at.z() > 0.36f; });
  EXPECT_GT(round, 4 * flat);
}

TEST(Simplification, AVertexHasTheEvidenceOfOneThatItStandsFor) {
  Mesh mesh = sphere_mesh(1, 5);
  for (const Vector3f& at : mesh.vertices)
    mesh.evidence.push_back(at.x() > 0 ? ShapeEvidence::kSeen : ShapeEvidence::kGuessed);
  const Mesh simple = simplified(mesh, 2000);
  ASSERT_EQ(simple.evidence.size(), simple.vertices.size());
  for (std::size_t v = 0; v < simple.vertices.size(); ++v) {
    const float x = simple.vertices[v].x();
    if (std::abs(x) > 0.15f)  // a triangle's side: 0.12
      EXPECT_EQ(simple.evidence[v], x > 0 ? ShapeEvidence::kSeen : ShapeEvidence::kGuessed);
  }
}

TEST(Simplification, TrianglesStayWhereThereIsDetail) {
  const Mesh mesh = sphere_mesh(1, 5);
  std::vector<float> detail;
  for (const Vector3f& vertex : mesh.vertices) detail.push_back(vertex.x() > 0 ? 100.0f : 1.0f);
  const Mesh simple = simplified(mesh, 1500, detail);
  expect_closed(simple);
  // On a sphere an edge's cost grows with the sixth power of its length: 100^(1/3) = 4.6 times the triangles.
  const double ratio = density(simple, [](const Vector3f& at) { return at.x() > 0.2f; }) /
                       density(simple, [](const Vector3f& at) { return at.x() < -0.2f; });
  EXPECT_GT(ratio, 3);
  EXPECT_LT(ratio, 7);
}

TEST(Simplification, TrianglesAreWellShaped) {
  const Mesh mesh = surface_of(60, [](const Vector3d& at) { return at.norm() - 0.8 + 0.05 * std::sin(9 * at.x()); });
  const Mesh simple = simplified(mesh, 2000);
  std::size_t slim = 0;
  for (std::size_t t = 0; t < simple.triangles.size(); ++t) {
    double sides = 0;
    for (int c = 0; c < 3; ++c) sides += (simple.corner(t, c) - simple.corner(t, (c + 1) % 3)).squaredNorm();
    slim += 2 * std::sqrt(3) * simple.area_normal(t).norm() < 0.3 * sides;
  }
  EXPECT_LT(slim, 20u);
}

TEST(Simplification, OfNoiseStaysClosedAndOfItsGenus) {
  std::size_t knotted = 0;
  for (unsigned seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 0.02 + 0.02 * (seed % 10));
    const Mesh mesh = surface_of(18 + seed % 9, [&](const Vector3d& at) { return at.norm() - 0.7 + noise(random); });
    for (const std::size_t part : {3, 10, 1000}) {
      const Mesh simple = simplified(mesh, mesh.triangles.size() / part);
      expect_closed(simple);
      EXPECT_EQ(euler_characteristic(simple), euler_characteristic(mesh));
      if (part == 3) EXPECT_LE(simple.triangles.size(), mesh.triangles.size() / 3);
    }
    knotted += euler_characteristic(mesh) < 0;
  }
  EXPECT_GT(knotted, 5u);
}

TEST(Simplification, EndsBeforeTheShapeIsLost) {
  const Mesh sphere = sphere_mesh(1, 4), least = simplified(sphere, 0);
  expect_closed(least);
  EXPECT_LT(least.triangles.size(), 400u);
  for (std::size_t t = 0; t < least.triangles.size(); ++t) {
    EXPECT_NEAR(least.corner(t, 0).norm(), 1, 0.03);
    EXPECT_NEAR(middle(least, t).norm(), 1, 0.06);
  }
}

TEST(Simplification, ASpongeDoesNotCostTheRestItsShape) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.04);
  const Vector3d half(0.03, 0.6, 0.6), at_plate(-0.3, 0, 0), at_ball(0.2, 0, 0);
  const Mesh mesh = surface_of(60, [&](const Vector3d& at) {
    const double plate = ((at - at_plate).cwiseAbs() - half).maxCoeff() + noise(random);
    return std::min(plate, (at - at_ball).norm() - 0.5);
  });
  ASSERT_LT(euler_characteristic(mesh), -100);
  const Mesh simple = simplified(mesh, 1000);
  expect_closed(simple);
  EXPECT_GT(simple.triangles.size(), 1000u);
  for (const Vector3f& vertex : simple.vertices)
    if (vertex.x() > 0) EXPECT_NEAR((vertex - at_ball.cast<float>()).norm(), 0.5, 0.05);
}

TEST(Simplification, WithoutAnythingToDoReturnsTheMesh) {
  const Mesh sphere = sphere_mesh(1, 3);
  const Mesh same = simplified(sphere, 100000);
  EXPECT_EQ(same.triangles, sphere.triangles);
  EXPECT_LT((same.vertices[7] - sphere.vertices[7]).norm(), 1e-6f);
  EXPECT_TRUE(simplified(Mesh{}, 10).triangles.empty());
}

TEST(Simplification, KeepsOriginAndScale) {
  Mesh mesh = sphere_mesh(1e-3f, 4);
  mesh.origin = {4.5e5, 5.4e6, 120};
  for (Vector3f& vertex : mesh.vertices) vertex.x() += 1;
  const Mesh simple = simplified(mesh, 500);
  expect_closed(simple);
  EXPECT_EQ(simple.origin, mesh.origin);
  EXPECT_EQ(simple.triangles.size(), 500u);
  for (const Vector3f& vertex : simple.vertices) EXPECT_NEAR((vertex - Vector3f(1, 0, 0)).norm(), 1e-3, 2e-5);
}

TEST(Simplification, TheBorderOfASheetStays) {
  const Mesh sheet = square_mesh(1, 0.5f, 20), simple = simplified(sheet, 200);
  EXPECT_LE(simple.triangles.size(), 200u);
  const MeshDiagnosis diagnosis = diagnose(simple);
  EXPECT_EQ(diagnosis.boundary_edges, 80u);
  EXPECT_EQ(diagnosis.non_manifold_edges, 0u);
  EXPECT_EQ(diagnosis.inconsistent_edges, 0u);
  double area = 0;
  for (std::size_t t = 0; t < simple.triangles.size(); ++t) area += simple.area_normal(t).z() / 2;
  EXPECT_NEAR(area, 4, 1e-5);
}

TEST(Simplification, WhatIsNoManifoldStaysAsItIs) {
  const Mesh soup = triangle_soup(sphere_mesh(1, 2));
  EXPECT_EQ(simplified(soup, 10).triangles.size(), soup.triangles.size());
  // Two spheres that share a vertex, one triangle that is listed twice, one without area, and one that is nowhere.
  Mesh mesh = sphere_mesh(1, 3);
  const auto shift = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  const Vector3f joint = mesh.vertices[0];
  const Mesh other = mesh;
  for (std::size_t v = 1; v < other.vertices.size(); ++v) mesh.vertices.push_back(2 * joint - other.vertices[v]);
  for (const auto& [a, b, c] : other.triangles)
    mesh.triangles.push_back({a ? a + shift : 0, c ? c + shift : 0, b ? b + shift : 0});
  mesh.triangles.push_back(mesh.triangles[100]);
  mesh.triangles.push_back({5, 5, 6});
  const Mesh simple = simplified(mesh, 400);
  EXPECT_LE(simple.triangles.size(), 400u);
  EXPECT_GT(broken_fans(simple), 0u);
  mesh.vertices[50].x() = std::numeric_limits<float>::quiet_NaN();
  simplified(mesh, 400);  // ends
}

}  // namespace
}  // namespace sheen
