// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/test_object.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "common/base/errors.h"
#include "common/geometry/ray_scene.h"
#include "common/simulation/implicit_surface.h"
#include "common/simulation/procedural_noise.h"

namespace sheen {
namespace {

using Eigen::Vector3f;

const TestObject& demo() {
  static const TestObject object = make_demo_object();
  return object;
}

/// Every edge once in each direction.
void expect_closed_and_wound(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
  for (const Triangle& t : mesh.triangles)
    for (int c = 0; c < 3; ++c) ++directed[{t[c], t[(c + 1) % 3]}];
  for (const auto& [edge, count] : directed) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(directed.contains({edge.second, edge.first}));
  }
}

double volume(const Mesh& mesh) {
  double six = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    six += mesh.corner(t, 0).dot(mesh.corner(t, 1).cross(mesh.corner(t, 2)));
  return six / 6;
}

TEST(DemoObject, IsClosedManifoldAndWoundOutward) {
  expect_closed_and_wound(demo().mesh);
  EXPECT_GT(volume(demo().mesh), 3e-4) << "a third of a litre";
  // V - E + F of a torus: the handle is its one hole.
  const auto v = demo().mesh.vertices.size(), f = demo().mesh.triangles.size();
  EXPECT_EQ(std::ptrdiff_t(v) - std::ptrdiff_t(3 * f / 2) + std::ptrdiff_t(f), 0);
}

TEST(DemoObject, HasAboutTwelveThousandEvenTriangles) {
  const Mesh& mesh = demo().mesh;
  EXPECT_NEAR(double(mesh.triangles.size()), 12000, 800);
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area += mesh.area_normal(t).norm() / 2;
  const double mean = area / double(mesh.triangles.size());
  int odd = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double a = mesh.area_normal(t).norm() / 2;
    odd += a < 0.4 * mean || a > 2.2 * mean;
    for (int c = 0; c < 3; ++c) {
      const Vector3f p = mesh.corner(t, c);
      const Vector3f e = (mesh.corner(t, (c + 1) % 3) - p).normalized(),
                     f = (mesh.corner(t, (c + 2) % 3) - p).normalized();
      EXPECT_GT(std::acos(e.dot(f)) * 180 / M_PI, 18) << "thin triangle " << t;
    }
  }
  EXPECT_LT(odd, 0.05 * double(mesh.triangles.size()));
}

TEST(DemoObject, StandsOnTheStageAndFitsBetweenItsTags) {
  Vector3f low = Vector3f::Constant(9), high = -low;
  for (const Vector3f& v : demo().mesh.vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  EXPECT_GE(low.z(), 0);
  EXPECT_LT(low.z(), 0.001);
  EXPECT_GT(high.z(), 0.100);
  EXPECT_LT(high.z(), 0.121);
  EXPECT_GT(low.x(), -0.13);
  EXPECT_LT(high.x(), 0.13);
  EXPECT_GT(low.y(), -0.08);
  EXPECT_LT(high.y(), 0.08);
}

TEST(DemoObject, NormalsPointOutAlongTheFacets) {
  const auto flat = vertex_normals(demo().mesh);
  ASSERT_EQ(flat.size(), demo().normals.size());
  for (std::size_t i = 0; i < flat.size(); ++i) {
    EXPECT_NEAR(demo().normals[i].norm(), 1, 1e-4);
    EXPECT_GT(flat[i].dot(demo().normals[i]), 0.7) << i;
  }
}

TEST(DemoObject, IsGlossyOverMoreThanHalfOfItsSurface) {
  const Mesh& mesh = demo().mesh;
  double glossy = 0, area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double a = mesh.area_normal(t).norm() / 2;
    const Material m = demo().material((mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3);
    area += a;
    if (phong_exponent(m.roughness) >= 20 && m.normal_reflectance.maxCoeff() >= 0.06f) glossy += a;
    EXPECT_GE(m.albedo.minCoeff(), 0);
    EXPECT_LE(m.albedo.maxCoeff(), 0.9f);
    EXPECT_LE(m.normal_reflectance.maxCoeff(), 0.9f);
  }
  EXPECT_GT(glossy / area, 0.6);
}

TEST(DemoObject, HidesPartsOfItself) {
  const RayScene rays(demo().mesh);
  const Vector3f eye(0.55f, 0.1f, 0.2f);
  int facing = 0, hidden = 0;
  for (std::size_t t = 0; t < demo().mesh.triangles.size(); ++t) {
    const Vector3f n = demo().mesh.area_normal(t).normalized();
    const Vector3f p = (demo().mesh.corner(t, 0) + demo().mesh.corner(t, 1) + demo().mesh.corner(t, 2)) / 3 + 1e-4f * n;
    if (n.dot(eye - p) <= 0) continue;
    ++facing;
    hidden += rays.occluded({p, eye - p, 0, 1});
  }
  EXPECT_GT(hidden, 0.05 * facing);
  EXPECT_LT(hidden, 0.5 * facing);
}

TEST(DemoObject, TextureHasDetailDownToAMillimetre) {
  // Albedo a millimetre apart differs almost as much as ten millimetres apart.
  const Mesh& mesh = demo().mesh;
  double near = 0, far = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 5) {
    const Vector3f p = mesh.corner(t, 0), tangent = (mesh.corner(t, 1) - p).normalized();
    const float here = demo().material(p).albedo[1];
    near += std::pow(here - demo().material(p + 0.001f * tangent).albedo[1], 2);
    far += std::pow(here - demo().material(p + 0.010f * tangent).albedo[1], 2);
  }
  EXPECT_GT(near, 0.2 * far);
}

TEST(BronzeObject, ShowsLittleButWhatItReflects) {
  const TestObject bronze = make_test_object("bronze");
  EXPECT_EQ(bronze.mesh.vertices, demo().mesh.vertices);
  double metal = 0, patina = 0;
  for (std::size_t t = 0; t < bronze.mesh.triangles.size(); ++t) {
    const Material m = bronze.material(bronze.mesh.corner(t, 0));
    ASSERT_GE(m.albedo.minCoeff(), 0);
    ASSERT_LE((m.albedo + m.normal_reflectance).maxCoeff(), 1) << "no more leaves than arrives";
    metal += m.normal_reflectance.maxCoeff() > 10 * m.albedo.maxCoeff() && phong_exponent(m.roughness) >= 15;
    patina += m.albedo[1] > 2 * m.albedo[0] && m.normal_reflectance.maxCoeff() < 0.1f;
  }
  EXPECT_GT(metal, 0.6 * double(bronze.mesh.triangles.size()));
  EXPECT_GT(patina, 0.02 * double(bronze.mesh.triangles.size()));
  EXPECT_LT(patina, 0.3 * double(bronze.mesh.triangles.size()));
}

TEST(DemoObject, IsTheSameEveryTime) {
  const TestObject again = make_demo_object();
  EXPECT_EQ(again.mesh.vertices, demo().mesh.vertices);
  EXPECT_EQ(again.mesh.triangles, demo().mesh.triangles);
  for (std::size_t i = 0; i < again.mesh.vertices.size(); i += 11) {
    const Material a = again.material(again.mesh.vertices[i]), b = demo().material(again.mesh.vertices[i]);
    EXPECT_TRUE((a.albedo == b.albedo).all());
    EXPECT_EQ(a.roughness, b.roughness);
  }
}

/// Every edge as often in each direction. Where a coarse mesh cannot part two sheets they may share an edge.
void expect_closed(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> surplus;
  for (const Triangle& t : mesh.triangles)
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t a = t[c], b = t[(c + 1) % 3];
      surplus[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  for (const auto& [edge, count] : surplus) EXPECT_EQ(count, 0);
}

TEST(DemoObject, HasMeshesOfOtherSizes) {
  for (const int triangles : {2700, 5000, 20000}) {
    const Mesh mesh = make_demo_mesh(triangles);
    expect_closed(mesh);
    EXPECT_NEAR(static_cast<double>(mesh.triangles.size()), triangles, 0.15 * triangles);
  }
}

TEST(Sphere, IsClosedAndRound) {
  const TestObject ball = make_sphere({}, 0.05, {0.1, 0.2, 0.3}, 3);
  expect_closed_and_wound(ball.mesh);
  EXPECT_EQ(ball.mesh.triangles.size(), 20u * 64);
  EXPECT_NEAR(volume(ball.mesh), 4.0 / 3 * M_PI * std::pow(0.05, 3), 0.01 * 5.2e-4);
  for (const Vector3f& v : ball.mesh.vertices) EXPECT_NEAR((v - Vector3f(0.1f, 0.2f, 0.3f)).norm(), 0.05, 1e-6);
}

TEST(ImplicitSurface, MeshesATorusOnItsSurface) {
  const auto torus = [](const Eigen::Vector3d& p) {
    return std::hypot(std::hypot(p.x(), p.y()) - 0.05, p.z()) - 0.015;
  };
  const Mesh mesh = mesh_implicit_surface(torus, {-0.08, -0.08, -0.03}, {0.08, 0.08, 0.03}, 0.004);
  expect_closed_and_wound(mesh);
  const double exact = 2 * M_PI * M_PI * 0.05 * 0.015 * 0.015;
  EXPECT_NEAR(volume(mesh), exact, 0.05 * exact);
  for (const Vector3f& v : mesh.vertices) EXPECT_NEAR(torus(v.cast<double>()), 0, 1e-5);
  EXPECT_THROW(mesh_implicit_surface(torus, {-0.06, -0.08, -0.03}, {0.08, 0.08, 0.03}, 0.004), ConfigError);
}

TEST(Noise, IsBoundedSmoothAndNotConstant) {
  double sum = 0, squares = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3f p(0.137f * float(i), 0.311f * float(i % 97), 0.071f * float(i % 31));
    const float v = gradient_noise(p);
    ASSERT_LE(std::abs(v), 1);
    ASSERT_NEAR(v, gradient_noise(p + Vector3f(1e-3f, 0, 0)), 0.02);
    sum += v, squares += v * v;
  }
  EXPECT_NEAR(sum / 20000, 0, 0.03);
  EXPECT_GT(squares / 20000, 0.02);
  EXPECT_EQ(gradient_noise({3, -2, 7}), 0) << "zero on the lattice";
}

TEST(TestObjects, UnknownNamesAreRefused) {
  EXPECT_THROW(make_test_object("bunny"), ConfigError);
}

}  // namespace
}  // namespace sheen
