// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/mesh_refinement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "reconstructor/refinement/mesh_findings.h"
#include "tests/reconstructor/refinement/ball_photographs.h"
#include "tests/support/expect_error.h"

namespace sheen {
namespace {

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

TEST(RefineMesh, FindsAPlaneAtItsHeight) {
  // The square lies at 0; the mesh lies below it by two pixels. Vertices near its border see what is beside it.
  const Photographs photographs({analytic::square(0.06, 0), analytic::diffuse(0.02), {0, 0, 0}}, 30, 0.4, false);
  const double below = 2 * kPixel;
  const Mesh given = square_mesh(0.06f, static_cast<float>(-below), 30);
  const RefinedMesh refined = refine_mesh(given, photographs.images());
  std::size_t inner = 0;
  double sum = 0, squares = 0;
  for (std::size_t v = 0; v < given.vertices.size(); ++v) {
    if (given.vertices[v].head<2>().cwiseAbs().maxCoeff() > 0.04f) continue;
    ++inner;
    const double off = refined.mesh.vertices[v].z();
    sum += off;
    squares += off * off;
    EXPECT_LT(std::abs(off), 3 * refined.uncertainty[v]);
  }
  const auto n = static_cast<double>(inner);
  EXPECT_LT(std::abs(sum / n), 0.05 * kPixel);
  EXPECT_LT(std::sqrt(squares / n), 0.05 * kPixel);
}

TEST(RefineMesh, StatesTheErrorThatIsLeft) {
  const Photographs photographs(ball(), 40, -0.98, false);
  const RefinedMesh refined = refine_mesh(waved_ball(0.01 * 2 * kRadius), photographs.images());
  double squared = 0;  // errors in standard deviations
  std::size_t observed = 0;
  for (std::size_t v = 0; v < refined.moved.size(); ++v) {
    if (!refined.observed[v]) continue;
    ++observed;
    squared += std::pow((refined.mesh.vertices[v].norm() - kRadius) / refined.uncertainty[v], 2);
  }
  EXPECT_LT(squared / static_cast<double>(observed), 2);
  EXPECT_GT(squared / static_cast<double>(observed), 0.1);
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

TEST(RefineMesh, WhatNoImageSawIsAsUncertainAsWhatTheySawWasWrong) {
  const Photographs photographs(ball(), 24, 0.3, false);  // from above only
  const RefinedMesh refined = refine_mesh(waved_ball(0.01 * 2 * kRadius), photographs.images());
  double squared = 0;  // errors in standard deviations
  std::size_t unseen = 0;
  for (std::size_t v = 0; v < refined.moved.size(); ++v) {
    if (refined.observed[v]) continue;
    ++unseen;
    squared += std::pow((refined.mesh.vertices[v].norm() - kRadius) / refined.uncertainty[v], 2);
  }
  ASSERT_GT(unseen, refined.moved.size() / 5);
  EXPECT_LT(squared / static_cast<double>(unseen), 2);
  EXPECT_GT(squared / static_cast<double>(unseen), 0.2);
}

TEST(RefineMesh, MasksHoldTheRimWhereNothingElseIsSeen) {
  // One colour: no image says anything about the surface but where it ends.
  const auto grey = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return Eigen::Vector3d(0.3, 0.3, 0.3); };
  const Photographs photographs({analytic::sphere(kRadius), grey}, 60, -0.98, true);
  const Mesh large = sphere_mesh(1.03f * kRadius, 4);
  const RefinedMesh refined = refine_mesh(large, photographs.images());
  EXPECT_LT(rms_from_ball(refined.mesh), 0.03 * kRadius / 4);
}

TEST(RefineMesh, EdgesShowTheRimWhereNoMaskDoes) {
  const auto grey = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return Eigen::Vector3d(0.3, 0.3, 0.3); };
  const Photographs photographs({analytic::sphere(kRadius), grey}, 60, -0.98, false);
  for (const float size : {1.03f, 0.97f}) {
    const Mesh wrong = sphere_mesh(size * kRadius, 4);
    const RefinedMesh refined = refine_mesh(wrong, photographs.images(), UnmaskedOutlines::kFromEdges);
    EXPECT_LT(rms_from_ball(refined.mesh), rms_from_ball(wrong) / 4) << size;
    // Nothing else tells: as the mesh has its outlines they stay.
    EXPECT_GT(rms_from_ball(refine_mesh(wrong, photographs.images()).mesh), 0.9 * rms_from_ball(wrong)) << size;
  }
}

TEST(RefineMesh, TextureBesideAnOutlineIsNotTakenForIt) {
  const Photographs photographs(ball(), 60, -0.98, false);
  const RefinedMesh right = refine_mesh(sphere_mesh(kRadius, 4), photographs.images(), UnmaskedOutlines::kFromEdges);
  EXPECT_LT(rms_from_ball(right.mesh), 0.2 * kPixel);
  const Mesh disturbed = waved_ball(0.01 * 2 * kRadius);
  const RefinedMesh refined = refine_mesh(disturbed, photographs.images(), UnmaskedOutlines::kFromEdges);
  EXPECT_LT(rms_from_ball(refined.mesh), 0.25 * rms_from_ball(disturbed));
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
