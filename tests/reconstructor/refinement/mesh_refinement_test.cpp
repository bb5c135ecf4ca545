// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/mesh_refinement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "reconstructor/refinement/mesh_findings.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/expect_error.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

constexpr double kRadius = 0.1, kDistance = 0.5;
const Camera kCamera{.width = 240, .height = 200, .fx = 420, .fy = 420, .cx = 119.5, .cy = 99.5};
constexpr double kPixel = kDistance / 420;  // on the object, metres

/// Photographs of a textured ball or square from all round (or above), exact but for what a point sample is.
class Photographs {
 public:
  Photographs(const analytic::Scene& scene, int count, double lowest, bool masks) {
    for (const Eigen::Vector3d& eye : analytic::eyes(count, kDistance, lowest)) {
      captures_.push_back(analytic::capture(scene, kCamera, analytic::towards_origin(eye)));
      if (masks) captures_.back().mask = mask(scene, captures_.back());
      images_.cameras.push_back({kCamera, captures_.back().pose.camera_from_object});
    }
    images_.read = [this](std::size_t i) { return captures_[i]; };
  }
  Photographs(const Photographs&) = delete;
  Photographs& operator=(const Photographs&) = delete;
  const RefinementImages& images() const { return images_; }

 private:
  static ImageU8 mask(const analytic::Scene& scene, const Capture& capture) {
    const Rigid3 object_from_camera = capture.pose.camera_from_object.inverse();
    ImageU8 mask(kCamera.width, kCamera.height, 1);
    for (int y = 0; y < kCamera.height; ++y)
      for (int x = 0; x < kCamera.width; ++x) {
        const Eigen::Vector3d ray = object_from_camera.rotation * *kCamera.ray({double(x), double(y)});
        mask.at(x, y) = scene.surface(object_from_camera.translation, ray) < analytic::kMiss ? 255 : 0;
      }
    return mask;
  }
  std::vector<Capture> captures_;
  RefinementImages images_;
};

analytic::Scene ball() {
  return {analytic::sphere(kRadius), analytic::diffuse(0.02)};
}

/// Of the vertices' distances from the ball's surface, metres.
double rms_from_ball(const Mesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3f& v : mesh.vertices) sum += std::pow(v.norm() - kRadius, 2);
  return std::sqrt(sum / static_cast<double>(mesh.vertices.size()));
}

/// A ball whose surface waves by this much RMS, metres.
Mesh waved_ball(double rms) {
  Mesh mesh = sphere_mesh(kRadius, 4);
  for (Eigen::Vector3f& v : mesh.vertices) {
    const Eigen::Vector3d p = v.cast<double>();
    const double wave = 2 / std::sqrt(3.0) * std::sqrt(2.0) *
                        (std::sin(40 * p.x() + 1) * std::cos(40 * p.y()) + 0.5 * std::sin(50 * p.z()));
    v *= static_cast<float>(1 + rms * wave / kRadius);
  }
  return mesh;
}

TEST(RefineMesh, BringsADisturbedBallBackToWithinAQuarterOfTheDisturbance) {
  const Photographs photographs(ball(), 40, -0.98, false);
  const Mesh disturbed = waved_ball(0.01 * 2 * kRadius);
  ASSERT_GT(rms_from_ball(disturbed), 0.008 * 2 * kRadius);
  const RefinedMesh refined = refine_mesh(disturbed, photographs.images());
  EXPECT_LT(rms_from_ball(refined.mesh), 0.25 * rms_from_ball(disturbed));
}

TEST(RefineMesh, LeavesARightMeshWithinItsUncertainty) {
  const Photographs photographs(ball(), 40, -0.98, false);
  const Mesh right = sphere_mesh(kRadius, 4);
  const RefinedMesh refined = refine_mesh(right, photographs.images());
  std::size_t beyond = 0;
  for (std::size_t v = 0; v < right.vertices.size(); ++v) {
    EXPECT_TRUE(refined.observed[v]);
    if (std::abs(refined.moved[v]) > 3 * refined.uncertainty[v]) ++beyond;
  }
  EXPECT_LT(static_cast<double>(beyond), 0.03 * static_cast<double>(right.vertices.size()));
  EXPECT_LT(rms_from_ball(refined.mesh), 0.1 * kPixel);
}

TEST(RefineMesh, SaysWhichVerticesNoImageSaw) {
  const Photographs photographs(ball(), 24, 0.3, false);  // from above only
  const RefinedMesh refined = refine_mesh(sphere_mesh(kRadius, 4), photographs.images());
  for (std::size_t v = 0; v < refined.moved.size(); ++v) {
    const float height = refined.mesh.vertices[v].z() / static_cast<float>(kRadius);
    if (height < -0.8f) {
      EXPECT_FALSE(refined.observed[v]);
    }
    if (height > 0.6f) EXPECT_TRUE(refined.observed[v]);
  }
}

TEST(RefineMesh, MasksHoldTheRimWhereNothingElseIsSeen) {
  // One colour: no image says anything about the surface but where it ends.
  const auto grey = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return Eigen::Vector3d(0.3, 0.3, 0.3); };
  const Photographs photographs({analytic::sphere(kRadius), grey}, 60, -0.98, true);
  const Mesh large = sphere_mesh(1.03f * kRadius, 4);
  const RefinedMesh refined = refine_mesh(large, photographs.images());
  EXPECT_LT(rms_from_ball(refined.mesh), 0.03 * kRadius / 3);
}

/// Kinds of what is found wrong with a mesh of the ball.
std::string found_wrong(const Mesh& mesh, const Photographs& photographs) {
  std::string kinds;
  const RefinedMesh refined = refine_mesh(mesh, photographs.images());
  for (const MeshFinding& finding : findings_of(mesh, refined, photographs.images())) kinds += finding.kind + ". ";
  return kinds;
}

TEST(MeshFindings, AMeshThatIsWrongAsAWholeIsNamed) {
  const Photographs photographs(ball(), 30, -0.98, true);
  EXPECT_EQ(found_wrong(sphere_mesh(kRadius, 4), photographs), "");
  EXPECT_EQ(found_wrong(sphere_mesh(1.02f * kRadius, 4), photographs), "scale. ");
  EXPECT_EQ(found_wrong(sphere_mesh(0.98f * kRadius, 4), photographs), "scale. ");
  Mesh moved = sphere_mesh(kRadius, 4);
  for (Eigen::Vector3f& v : moved.vertices) v += Eigen::Vector3f(0.002f, -0.001f, 0.001f);
  EXPECT_EQ(found_wrong(moved, photographs), "offset. ");
}

TEST(MeshFindings, TheSimilarityIsTheOneThatMovedTheMesh) {
  const Mesh mesh = sphere_mesh(kRadius, 3);
  RefinedMesh refined{.mesh = mesh};
  refined.observed.assign(mesh.vertices.size(), true);
  const Eigen::Vector3d offset(0.001, 0.002, -0.003);
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Eigen::Vector3d n = normals[v].cast<double>();
    refined.moved.push_back(static_cast<float>(n.dot(0.01 * mesh.vertices[v].cast<double>() + offset)));
    if (v % 10 == 0) refined.moved.back() = 0.05f;  // a tenth went astray
  }
  const MeshOffset common = common_offset(mesh, refined);
  EXPECT_NEAR(common.scale, 0.01, 0.002);
  EXPECT_LT((common.offset - offset).norm(), 0.0003);
}

TEST(MeshFindings, APartThatTheMeshHasNotIsNamed) {
  // The object is a ball with a smaller one beside it; the mesh is the large ball alone.
  const analytic::Surface small = [](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
    return analytic::sphere(0.4 * kRadius)(eye - Eigen::Vector3d(1.2 * kRadius, 0, 0), ray);
  };
  const Photographs photographs({analytic::nearest_of(analytic::sphere(kRadius), small), analytic::diffuse(0.02)}, 30,
                                -0.98, true);
  EXPECT_EQ(found_wrong(sphere_mesh(kRadius, 4), photographs), "missing part. ");
}

TEST(RefineMesh, AsksForTwoImages) {
  const Photographs photographs(ball(), 1, 0.3, false);
  expect_error<Error>([&] { refine_mesh(sphere_mesh(kRadius, 2), photographs.images()); }, {"two images"});
}

}  // namespace
}  // namespace sheen
