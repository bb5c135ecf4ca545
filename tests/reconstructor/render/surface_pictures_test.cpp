// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/surface_pictures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "reconstructor/render/ray_painter.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kRadius = 0.5;
constexpr int kLevels = 5;
/// Of the sphere's mesh: an edge of an icosahedron on the unit sphere, halved so often, is no longer than this.
const double kEdge = 1.2 * kRadius / std::pow(2, kLevels);

PosedCamera looking_at_origin(const Vector3d& eye) {
  Camera camera{.width = 120, .height = 90, .fx = 110, .fy = 105, .cx = 62, .cy = 41};
  camera.distortion = {0.08, -0.02, 1e-3, -1e-3, 0};
  return {camera, look_at(eye, Vector3d::Zero(), Vector3d::UnitZ())};
}

/// Where a pixel's ray meets the sphere first, or from within; object frame.
std::optional<Vector3d> on_sphere(const PosedCamera& from, int x, int y) {
  const Vector3d eye = camera_centre(from.camera_from_object),
                 direction = from.camera_from_object.rotation.conjugate() * *from.camera.ray({double(x), double(y)});
  const double b = eye.dot(direction), c = eye.squaredNorm() - kRadius * kRadius, root = b * b - c;
  if (root < 0) return std::nullopt;
  const double near = -b - std::sqrt(root);
  return eye + (near > 0 ? near : -b + std::sqrt(root)) * direction;
}

struct Sphere {
  Mesh mesh = sphere_mesh(static_cast<float>(kRadius), kLevels);
  RayPainter painter{mesh};
  std::vector<Vector3f> normals = vertex_normals(mesh);

  ImageF depth(const PosedCamera& from) const {
    return depth_picture(mesh, painter.cast(from.camera, from.camera_from_object), from);
  }
  ImageF normal(const PosedCamera& from) const {
    return normal_picture(mesh, normals, painter.cast(from.camera, from.camera_from_object), from.camera);
  }
};

/// `side`: 1 outside, -1 inside.
void expect_that_of_the_sphere(const PosedCamera& from, double side) {
  const Sphere sphere;
  const ImageF depth = sphere.depth(from), normal = sphere.normal(from);
  const Vector3d eye = camera_centre(from.camera_from_object);
  int seen = 0;
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      const auto place = on_sphere(from, x, y);
      if (!place) {
        EXPECT_EQ(depth.at(x, y), std::numeric_limits<float>::infinity()) << x << " " << y;
        EXPECT_EQ(Vector3f::Map(normal.pixel(x, y)), Vector3f::Zero());
        continue;
      }
      const Vector3d outward = place->normalized();
      const double cosine = side * outward.dot((eye - *place).normalized());
      if (cosine < 0.3) continue;  // the outline of the mesh lies within the sphere's
      ++seen;
      const double sagitta = kEdge * kEdge / (2 * kRadius);
      EXPECT_NEAR(depth.at(x, y), (from.camera_from_object * *place).z(), sagitta / cosine + 1e-5) << x << " " << y;
      const Vector3d shown = Vector3f::Map(normal.pixel(x, y)).cast<double>();
      EXPECT_NEAR(shown.norm(), 1, 1e-5);
      EXPECT_GT(shown.dot(side * outward), std::cos(kEdge / kRadius / 4)) << x << " " << y;
    }
  EXPECT_GT(seen, 1000);
}

TEST(SurfacePictures, DepthAndNormalsAreThoseOfASphere) {
  expect_that_of_the_sphere(looking_at_origin({0.9, -0.8, 0.7}), 1);
}

TEST(SurfacePictures, FromWithinNormalsFaceTheEye) {
  expect_that_of_the_sphere(looking_at_origin({0.1, 0.05, -0.1}), -1);
}

TEST(SurfacePictures, DepthIsAlongTheAxisAndNotAlongTheRay) {
  Mesh wall;
  wall.vertices = {{-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  const PosedCamera from = looking_at_origin({0, 0.001, 2});
  const std::vector<Hit> hits = RayPainter(wall).cast(from.camera, from.camera_from_object);
  const ImageF depth = depth_picture(wall, hits, from);
  const auto [least, most] = std::minmax_element(depth.data(), depth.data() + depth.size());
  EXPECT_NEAR(*least, 2, 2e-3);
  EXPECT_NEAR(*most, 2, 2e-3);
}

TEST(SurfacePictures, DepthOfPlacesIsInfiniteWhereTheyAreNotKnown) {
  const PosedCamera from = looking_at_origin({0, -2, 0});
  ImageF places(from.camera.width, from.camera.height, 3);
  std::vector<bool> known(places.size() / 3, false);
  known[17] = true;
  Vector3f::Map(places.data() + 3 * 17) = Vector3f(0.3f, 0.5f, 0.1f);
  const ImageF depth = depth_picture(places, known, from);
  EXPECT_NEAR(depth.data()[17], 2.5, 1e-6);
  EXPECT_EQ(depth.data()[18], std::numeric_limits<float>::infinity());
}

}  // namespace
}  // namespace sheen
