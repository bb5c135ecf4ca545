// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/ray_scene.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "tests/support/analytic_scene.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

std::vector<Ray> random_rays(int count, double eye_radius, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<float> normal;
  const auto any = [&] { return Eigen::Vector3f(normal(engine), normal(engine), normal(engine)); };
  std::vector<Ray> rays(count);
  for (Ray& ray : rays) {
    ray.origin = static_cast<float>(eye_radius) * any().normalized();
    ray.direction = 0.5f * any().normalized() - ray.origin;  // some pass a unit sphere, some hit it
    ray.direction *= std::exp(normal(engine));
  }
  return rays;
}

Eigen::Vector3f at(const Mesh& mesh, const Hit& hit) {
  return (1 - hit.u - hit.v) * mesh.corner(hit.triangle, 0) + hit.u * mesh.corner(hit.triangle, 1) +
         hit.v * mesh.corner(hit.triangle, 2);
}

TEST(RayScene, ManyRaysAtOnceAreStoppedAsEachAlone) {
  const Mesh mesh = square_mesh(1, 0.25f, 7);
  const RayScene scene(mesh);
  for (const int count : {0, 1, 7, 8, 9, 300}) {  // whole packets, and what is left of one
    const std::vector<Ray> rays = random_rays(count, 3, 4);
    std::vector<std::uint8_t> blocked(rays.size());
    scene.occluded(rays, blocked);
    int stopped = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(blocked[i], scene.occluded(rays[i])) << i << " of " << count;
      stopped += blocked[i];
    }
    if (count == 300) {
      EXPECT_GT(stopped, 30);
      EXPECT_LT(stopped, 270);
    }
  }
  std::vector<std::uint8_t> few(2);
  EXPECT_THROW(scene.occluded(random_rays(3, 3, 4), few), std::invalid_argument);
}

TEST(RayScene, AgreesWithTheClosedFormOfAPlane) {
  const Mesh mesh = square_mesh(1, 0.25f, 7);
  const RayScene scene(mesh);
  const analytic::Surface square = analytic::square(1, 0.25);
  int hits = 0, misses = 0;
  for (const Ray& ray : random_rays(2000, 3, 1)) {
    const Eigen::Vector3d eye = ray.origin.cast<double>(), unit = ray.direction.cast<double>().normalized();
    const double t = (0.25 - eye.z()) / unit.z();
    const Eigen::Vector3d p = eye + t * unit;
    const double rim = std::max(std::abs(p.x()), std::abs(p.y()));
    if (std::abs(rim - 1) < 1e-5) continue;
    const Hit hit = scene.intersect(ray);
    ASSERT_EQ(bool(hit), t > 0 && rim < 1) << p.transpose();
    EXPECT_EQ(scene.occluded(ray), bool(hit));
    if (!hit) {
      ++misses;
      continue;
    }
    ++hits;
    EXPECT_NEAR(hit.distance * ray.direction.norm(), t, 1e-5 * t) << "distances count in lengths of the direction";
    EXPECT_EQ(hit.front, unit.z() < 0);
    EXPECT_EQ(hit.front, square(eye, unit) < analytic::kMiss);
    EXPECT_LT((at(mesh, hit).cast<double>() - p).norm(), 1e-5);
  }
  EXPECT_GT(hits, 300);
  EXPECT_GT(misses, 300);
}

TEST(RayScene, AgreesWithTheClosedFormOfASphereToWithinItsFacets) {
  const Mesh mesh = sphere_mesh(1, 4);
  const RayScene scene(mesh);
  double inner = 1;  // radius of the sphere that fits inside the facets
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    inner = std::min(inner, double(std::abs(mesh.area_normal(t).normalized().dot(mesh.corner(t, 0)))));
  ASSERT_GT(inner, 0.998);
  for (const Ray& ray : random_rays(2000, 3, 2)) {
    const Eigen::Vector3d eye = ray.origin.cast<double>(), unit = ray.direction.cast<double>().normalized();
    const Hit hit = scene.intersect(ray);
    const double outside = analytic::sphere(1)(eye, unit), inside = analytic::sphere(inner)(eye, unit);
    if (inside < analytic::kMiss) {
      ASSERT_TRUE(hit);
      EXPECT_TRUE(hit.front);
      const double t = hit.distance * ray.direction.norm();
      EXPECT_GE(t, outside - 1e-5);
      EXPECT_LE(t, inside + 1e-5);
    }
    if (outside == analytic::kMiss) EXPECT_FALSE(hit);
  }
  EXPECT_FALSE(scene.intersect({{0, 0, 0}, {0.3f, 0.2f, 0.9f}}).front) << "from within, back faces are seen";
}

TEST(RayScene, PacketsGiveWhatSingleRaysGive) {
  const RayScene scene(joined(sphere_mesh(0.7f, 3), square_mesh(1, 0, 5)));
  for (const int count : {0, 1, 7, 8, 9, 1003}) {
    std::vector<Ray> rays = random_rays(count, 2.5, 3);
    for (std::size_t i = 0; i < rays.size(); i += 5) {
      rays[i].near = 0;
      rays[i].far = -1;  // an empty interval
    }
    std::vector<Hit> hits(rays.size());
    scene.intersect(rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Hit single = scene.intersect(rays[i]);
      if (i % 5 == 0) EXPECT_FALSE(hits[i]);
      ASSERT_EQ(bool(hits[i]), bool(single)) << i;
      if (!single) continue;
      EXPECT_NEAR(hits[i].distance, single.distance, 2e-6 * single.distance);
      EXPECT_EQ(hits[i].front, single.front);
      if (hits[i].triangle != single.triangle) continue;  // a ray through a shared edge may land on either side
      EXPECT_NEAR(hits[i].u, single.u, 1e-4);
      EXPECT_NEAR(hits[i].v, single.v, 1e-4);
    }
  }
}

TEST(RayScene, NearAndFarBoundTheRay) {
  const RayScene scene(joined(square_mesh(1, 0, 1), square_mesh(1, 1, 1)));
  const Eigen::Vector3f eye(0.1f, 0.2f, 3), down(0, 0, -2);  // meets the squares at 1 and at 1.5
  EXPECT_FLOAT_EQ(scene.intersect({eye, down}).distance, 1);
  EXPECT_FLOAT_EQ(scene.intersect({eye, down, 1.1f}).distance, 1.5f);
  EXPECT_FALSE(scene.intersect({eye, down, 0, 0.9f}));
  EXPECT_FALSE(scene.occluded({eye, down, 1.1f, 1.4f}));
  EXPECT_TRUE(scene.occluded({eye, down, 1.1f, 1.6f}));
}

TEST(RayScene, NoRaySlipsThroughAnEdge) {
  const Mesh mesh = sphere_mesh(1, 3);
  const RayScene scene(mesh);
  std::mt19937 engine(4);
  std::uniform_real_distribution<float> fraction(0.001f, 0.999f);
  std::vector<Ray> rays;
  for (const Triangle& t : mesh.triangles)
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 8; ++k) {
        const Eigen::Vector3f a = mesh.vertices[t[c]], b = mesh.vertices[t[(c + 1) % 3]];
        const float w = fraction(engine);
        const Eigen::Vector3f target = w * a + (1 - w) * b, aside(fraction(engine), fraction(engine), fraction(engine));
        const Eigen::Vector3f eye = 3 * (target + 0.5f * aside).normalized();
        rays.push_back({eye, target - eye});
      }
  std::vector<Hit> hits(rays.size());
  scene.intersect(rays, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_TRUE(hits[i] && hits[i].front) << rays[i].direction.transpose();
    EXPECT_TRUE(scene.intersect(rays[i]).front);
  }
}

TEST(RayScene, AsManyHitsAsRaysAreDemanded) {
  const RayScene scene(square_mesh(1, 0, 1));
  const std::vector<Ray> rays(3);
  std::vector<Hit> hits(2);
  EXPECT_THROW(scene.intersect(rays, hits), std::invalid_argument);
}

}  // namespace
}  // namespace sheen
