// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/mesh_scale.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "common/capture/moved_origin.h"
#include "tests/support/expect_error.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using ::testing::HasSubstr;

Mesh scaled(Mesh mesh, float by) {
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex *= by;
  return mesh;
}

/// Eyes on a sphere round the origin that look at it.
std::vector<PosedCamera> cameras(double distance) {
  std::vector<PosedCamera> out;
  const Camera camera{.width = 640, .height = 480, .fx = 700, .fy = 700, .cx = 319.5, .cy = 239.5};
  for (int i = 0; i < 20; ++i)
    out.push_back(
        {camera, look_at({distance * std::cos(i), distance * std::sin(i), 0.2 * distance}, {0, 0, 0}, {0, 0, 1})});
  return out;
}

TEST(MeshScale, OneThatTheCamerasSeeIsNotDoubted) {
  for (const double distance : {0.08, 0.2, 1.0, 5.0}) {
    const MeshScale judged = judge_scale(sphere_mesh(0.05f, 2), cameras(distance));
    EXPECT_EQ(judged.finding, "") << distance;
    EXPECT_EQ(judged.fitting, 1);
  }
  EXPECT_EQ(judge_scale(sphere_mesh(0.05f, 2), {}).finding, "") << "nobody looks";
}

TEST(MeshScale, MillimetresAreRecognised) {
  const Mesh mesh = scaled(sphere_mesh(0.05f, 2), 1000);
  const MeshScale judged = judge_scale(mesh, cameras(0.2));
  EXPECT_EQ(judged.fitting, 0);
  EXPECT_EQ(judged.remedy, 0.001);
  EXPECT_THAT(judged.finding, HasSubstr("100 x 100 x 100 m"));
  EXPECT_THAT(judged.finding, HasSubstr("looks like millimetres: scale the mesh by 0.001"));
  expect_error<FileError>([&] { check_scale("ball.ply", mesh, cameras(0.2)); },
                          {"ball.ply", "scale the mesh by 0.001"});
}

TEST(MeshScale, PosesInMillimetresAreRecognised) {
  const MeshScale judged = judge_scale(sphere_mesh(0.05f, 2), cameras(200));
  EXPECT_EQ(judged.remedy, 1000);
  EXPECT_THAT(judged.finding, HasSubstr("poses millimetres"));
}

TEST(MeshScale, AnotherFrameIsDoubtedButNotRefused) {
  Mesh mesh = sphere_mesh(0.05f, 2);
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex.x() += 50;
  const MeshScale judged = judge_scale(mesh, cameras(0.2));
  EXPECT_FALSE(judged.remedy);
  EXPECT_THAT(judged.finding, HasSubstr("only 0 % of them can see it"));
  EXPECT_NO_THROW(check_scale("ball.ply", mesh, cameras(0.2)));
}

TEST(MeshScale, ALiveCaptureIsJudgedOnceByItsFirstKeyframes) {
  const Mesh mesh = scaled(sphere_mesh(0.05f, 2), 1000);
  ScaleWatch watch(mesh);
  int told = 0;
  for (const PosedCamera& view : cameras(0.2)) {
    Capture capture;
    capture.camera = view.camera;
    capture.pose = {.status = PoseStatus::kGiven, .camera_from_object = view.camera_from_object};
    capture.verdict = FrameVerdict::kTooNear;
    EXPECT_EQ(watch.look(capture), "");
    capture.verdict = FrameVerdict::kKeyframe;
    told += watch.look(capture).empty() ? 0 : 1;
  }
  EXPECT_EQ(told, 1);
}

TEST(MeshScale, SaysTheSize) {
  EXPECT_EQ(size_text(sphere_mesh(0.05f, 2)), "100 x 100 x 100 mm");
  EXPECT_EQ(size_text(sphere_mesh(2, 2)), "4 x 4 x 4 m");
}

TEST(MeshScale, AMeshFarFromZeroIsJudgedWhereItStands) {
  const Eigen::Vector3d place(0, 0, 10);  // a thousand times as far, no camera looks there
  std::vector<PosedCamera> there;
  for (const PosedCamera& camera : cameras(0.2)) there.push_back(in_frame_at(-place, camera));
  for (const auto& [scale, fitting] : {std::pair{1.0, 1.0}, {1000.0, 0.0}}) {
    std::vector<Eigen::Vector3d> vertices;
    const Mesh ball = sphere_mesh(0.05f, 2);
    for (const Eigen::Vector3f& v : ball.vertices) vertices.push_back(scale * (v.cast<double>() + place));
    const Mesh mesh = mesh_of(vertices, ball.triangles);
    ASSERT_FALSE(mesh.origin.isZero(0));
    const MeshScale judged = judge_scale(mesh, there);
    EXPECT_EQ(judged.fitting, fitting);
    EXPECT_EQ(judged.remedy.value_or(1), 1 / scale);
  }
}

}  // namespace
}  // namespace sheen
