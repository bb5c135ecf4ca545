// SPDX-License-Identifier: Apache-2.0
#include "common/registration/placement_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "common/registration/frame_mistakes.h"
#include "tests/common/registration/ellipsoid_photographs.h"
#include "tests/common/registration/lopsided_object.h"

namespace sheen {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// The object's mesh as it would be in another frame: what `wrong_from_right` makes of it.
Mesh in_another_frame(const Eigen::Affine3d& wrong_from_right) {
  Mesh mesh = lopsided_mesh();
  for (Eigen::Vector3f& v : mesh.vertices) v = (wrong_from_right * v.cast<double>()).cast<float>();
  if (wrong_from_right.linear().determinant() < 0)
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

Eigen::Affine3d axes(const Eigen::Vector3d& x, const Eigen::Vector3d& y, const Eigen::Vector3d& z) {
  Eigen::Affine3d frame = Eigen::Affine3d::Identity();
  frame.linear() << x.transpose(), y.transpose(), z.transpose();
  return frame;
}

TEST(PlacementWarning, ComesWithinThreeImagesWhereTheMeshStandsElsewhere) {
  for (const bool masks : {false, true}) {
    const std::vector<RegistrationImage> images =
        images_in_turn({ellipsoid(), analytic::diffuse(0.012)}, masks, kImagesToCheck);
    const Mesh right = ellipsoid_mesh(kAxes, Eigen::Vector3d::Zero(), 4);
    EXPECT_EQ(placement_warning(right, images).text, "") << masks;
    for (int axis = 0; axis < 3; ++axis) {
      Mesh off = right;
      for (Eigen::Vector3f& v : off.vertices) v[axis] += 0.010f;
      EXPECT_THAT(placement_warning(off, images, {.on_stage = true, .applied = {}, .more = {}}).text,
                  HasSubstr("`sheen-tracker register`"))
          << masks << " " << axis;
      EXPECT_THAT(placement_warning(off, images).text,
                  AllOf(HasSubstr("reconstruction"), Not(HasSubstr("sheen-tracker"))))
          << "photographs have no stage";
    }
    Mesh lying = right;  // y up
    for (Eigen::Vector3f& v : lying.vertices) v = Eigen::Vector3f(v.x(), -v.z(), v.y());
    EXPECT_NE(placement_warning(lying, images).text, "") << masks;
  }
}

TEST(PlacementWarning, NamesAMeshThatReachesBelowTheStage) {
  const std::vector<RegistrationImage> none;
  EXPECT_THAT(placement_warning(ellipsoid_mesh(), none, {.on_stage = true, .applied = {}, .more = {}}).text,
              HasSubstr("mm below the stage"));
}

TEST(PlacementWarning, NamesWhatTurnsTheMeshBack) {
  const auto x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  const struct {
    Eigen::Affine3d wrong;
    std::string remedy;
  } cases[] = {
      {axes(x, -y, -z), "turn it by 180 degrees about x, so that (x, y, z) becomes (x, -y, -z)"},
      {axes(-x, -y, z), "turn it by 180 degrees about z"},
      {axes(x, -z, y), "(x, y, z) becomes (x, z, -y)"},
      {axes(x, z, -y), "(x, y, z) becomes (x, -z, y)"},
      {axes(y, x, -z), "(x, y, z) becomes (y, x, -z)"},
      {axes(y, z, x), "(x, y, z) becomes (z, x, y)"},
      {axes(x, z, y), "(x, y, z) becomes (x, z, y)"},  // mirrored
  };
  const std::vector<RegistrationImage> masked = from_three_sides(lopsided(), true),
                                       unmasked = from_three_sides(lopsided(), false);
  for (const auto& [wrong, remedy] : cases) {
    const Mesh mesh = in_another_frame(wrong);
    const auto found = find_frame_mistake(mesh, unmasked);
    ASSERT_TRUE(found) << remedy;
    EXPECT_THAT(found->remedy, HasSubstr(remedy));
    const PlacementWarning warning =
        placement_warning(mesh, std::span(masked).first(kImagesToCheck),
                          {.on_stage = false, .applied = {}, .more = [&] { return masked; }});
    EXPECT_TRUE(warning.explained);
    EXPECT_THAT(warning.text, AllOf(HasSubstr(remedy), Not(HasSubstr("sheen-tracker"))));
  }
}

TEST(PlacementWarning, NamesWhatWasAppliedToThePosesAlone) {
  const std::vector<RegistrationImage> all = from_three_sides(lopsided(), false);
  Similarity applied;  // no turn by right angles
  applied.rotation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  applied.translation = {0.1, 0.2, -0.05};
  Eigen::Affine3d before = Eigen::Affine3d::Identity();
  before.linear() = applied.rotation.transpose();
  before.translation() = -(applied.rotation.transpose() * applied.translation);
  EXPECT_THAT(placement_warning(in_another_frame(before), std::span(all).first(kImagesToCheck),
                                {.on_stage = false, .applied = applied, .more = [&] { return all; }})
                  .text,
              HasSubstr("apply `applied_transform` to it, or its inverse to the poses"));
}

TEST(FrameMistakes, AUnitAndAMeshThatWasCentred) {
  const std::vector<RegistrationImage> all = from_three_sides(lopsided(), true);
  Eigen::Affine3d wrong = Eigen::Affine3d::Identity();
  wrong.linear() *= 0.1;
  const auto unit = find_frame_mistake(in_another_frame(wrong), all);
  ASSERT_TRUE(unit);
  EXPECT_DOUBLE_EQ(unit->poses_from_mesh.scale, 10);
  const Eigen::Vector3d off(0.03, 0.1, 0.02);
  const auto moved = find_frame_mistake(in_another_frame(Eigen::Affine3d(Eigen::Translation3d(off))), all);
  ASSERT_TRUE(moved);
  EXPECT_LT((moved->poses_from_mesh.translation + off).norm(), 0.015);
}

TEST(FrameMistakes, NoneWhereTheMeshStandsRightOrIsAnotherObjects) {
  for (const bool masks : {false, true}) {
    const std::vector<RegistrationImage> all = from_three_sides(lopsided(), masks);
    EXPECT_FALSE(find_frame_mistake(lopsided_mesh(), all)) << masks;
    Mesh other = sphere_mesh(0.03f, 4);
    for (Eigen::Vector3f& v : other.vertices) v += Eigen::Vector3f(0.1f, 0.1f, 0.2f);
    EXPECT_FALSE(find_frame_mistake(other, all)) << masks;
  }
}

}  // namespace
}  // namespace sheen
