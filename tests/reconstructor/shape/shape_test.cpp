// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/reconstructor/refinement/ball_photographs.h"
#include "tests/support/expect_error.h"

namespace sheen {
namespace {

void expect_closed(const Mesh& mesh) {
  const MeshDiagnosis found = diagnose(mesh);
  EXPECT_EQ(found.boundary_edges, 0u);
  EXPECT_EQ(found.non_manifold_edges, 0u);
  EXPECT_EQ(found.inconsistent_edges, 0u);
  EXPECT_EQ(found.components, 1u);
  EXPECT_GT(found.signed_volume, 0);
}

analytic::Scene ball_before(const Eigen::Vector3d& background) {
  analytic::Scene scene = ball();
  scene.background = background;
  return scene;
}

TEST(FindShape, ABallWithMasks) {
  const Photographs photographs(ball(), 24, -0.98, true);
  const FoundShape found = find_shape(photographs.images(), {.triangles = 3000});
  expect_closed(found.mesh);
  EXPECT_EQ(found.outlines, 24);
  EXPECT_TRUE(found.coherent) << "masks that agree are believed";
  EXPECT_GT(share_known_as(ShapeEvidence::kSeen, found.mesh), 0.9);
  EXPECT_LT(rms_from_ball(found.mesh), 0.5 * kPixel);
  EXPECT_LE(found.mesh.triangles.size(), 3000u);
}

TEST(FindShape, ABallBeforeADarkBackground) {
  const Photographs photographs(ball_before({0.001, 0.001, 0.001}), 24, -0.98, false);
  const FoundShape found = find_shape(photographs.images(), {.triangles = 3000});
  expect_closed(found.mesh);
  EXPECT_GT(found.outlines, 20);
  EXPECT_LT(rms_from_ball(found.mesh), 0.5 * kPixel);
}

constexpr double kSmall = 0.05;  // radius of a ball that stands on a table

analytic::Scene ball_on_table() {
  return {analytic::nearest_of(analytic::sphere(kSmall), analytic::square(0.6, -kSmall)), analytic::diffuse(0.03)};
}

/// Nothing is known of any outline.
TEST(FindShape, ABallOnATable) {
  const Photographs photographs(ball_on_table(), 24, 0.3, false);
  const FoundShape found = find_shape(photographs.images(), {});
  expect_closed(found.mesh);
  EXPECT_EQ(found.outlines, 0);
  double squares = 0;
  std::size_t upper = 0, table = 0, on_table = 0;
  for (std::size_t v = 0; v < found.mesh.vertices.size(); ++v) {
    if (found.mesh.evidence[v] != ShapeEvidence::kSeen) continue;
    const Eigen::Vector3d p = found.mesh.vertices[v].cast<double>();
    if (p.z() > 0.2 * kSmall) {
      squares += std::pow(p.norm() - kSmall, 2);
      ++upper;
    } else if (p.head<2>().norm() > 1.3 * kSmall) {
      ++table;
      on_table += std::abs(p.z() + kSmall) < 2 * kPixel ? 1 : 0;
    }
  }
  ASSERT_GT(upper, 200u);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(upper)), 0.75 * kPixel);
  ASSERT_GT(table, 100u);
  EXPECT_GT(static_cast<double>(on_table), 0.9 * static_cast<double>(table));
}

/// The same; somebody has a box round the ball.
TEST(FindShape, ARoughMeshTakesTheTableAway) {
  const Photographs photographs(ball_on_table(), 24, 0.3, false);
  const Mesh rough = sphere_mesh(1.02f * kSmall, 3);
  const FoundShape found = find_shape(photographs.images(), {.from = &rough});
  expect_closed(found.mesh);
  EXPECT_EQ(found.outlines, 24);
  EXPECT_TRUE(found.coherent);
  std::size_t near = 0;
  for (const Eigen::Vector3f& v : found.mesh.vertices) {
    EXPECT_LT(v.head<2>().norm(), 1.2 * kSmall) << "of the table is left what the ball stands before in every image";
    near += std::abs(v.norm() - kSmall) < 0.06 * 2 * kSmall ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(near), 0.9 * static_cast<double>(found.mesh.vertices.size()));
}

/// As far from zero as map coordinates are.
TEST(FindShape, FarFromTheOriginOfItsFrame) {
  const Photographs photographs(ball(), 24, -0.98, true);
  const Eigen::Vector3d far(400'000, 5'600'000, 120);
  RefinementImages images = photographs.images();
  for (PosedCamera& camera : images.cameras)
    camera.camera_from_object.translation -= camera.camera_from_object.rotation * far;
  images.read = [&](std::size_t i) {
    Capture capture = photographs.images().read(i);
    capture.pose.camera_from_object = images.cameras[i].camera_from_object;
    return capture;
  };
  FoundShape found = find_shape(images, {.triangles = 3000});
  expect_closed(found.mesh);
  const Eigen::Vector3f back = (found.mesh.origin - far).cast<float>();
  for (Eigen::Vector3f& vertex : found.mesh.vertices) vertex += back;
  EXPECT_LT(rms_from_ball(found.mesh), 0.5 * kPixel);
}

TEST(FindShape, TheSameImagesGiveTheSameBits) {
  const Photographs photographs(ball(), 12, -0.98, true);
  const FoundShape one = find_shape(photographs.images(), {}), two = find_shape(photographs.images(), {});
  EXPECT_EQ(one.mesh.vertices, two.mesh.vertices);
  EXPECT_EQ(one.mesh.triangles, two.mesh.triangles);
}

TEST(FindShape, SaysWhyThereIsNone) {
  const auto find = [](const Photographs& photographs) { find_shape(photographs.images(), {}); };
  const Photographs two(ball(), 2, -0.98, true);
  expect_error<Error>([&] { find(two); }, {"only 2 of the images have a pose", "3 or more"});
  // Ten from one place.
  const Photographs one(ball(), 1, 0.5, true);
  RefinementImages still = one.images();
  still.cameras.resize(10, still.cameras[0]);
  still.read = [&](std::size_t) { return one.images().read(0); };
  expect_error<Error>([&] { find_shape(still, {}); }, {"several sides"});
  // Nothing but black.
  analytic::Scene nothing = ball_before({0, 0, 0});
  nothing.surface = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return analytic::kMiss; };
  const Photographs black(nothing, 12, -0.98, false);
  expect_error<Error>([&] { find(black); }, {"agree about no surface"});
}

}  // namespace
}  // namespace sheen
