// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/mesh_judgement.h"
#include "common/registration/silhouette.h"

#include <gtest/gtest.h>

#include "reconstructor/refinement/kept_outlines.h"
#include "tests/reconstructor/refinement/ball_photographs.h"

namespace sheen {
namespace {

/// Every fourth image is left out.
LeftOutGain judged(const Mesh& given, const Mesh& refined, const Photographs& photographs) {
  LeftOut split;
  for (std::size_t i = 0; i < photographs.images().cameras.size(); ++i)
    (i % 4 == 0 ? split.left_out : split.others).push_back(i);
  return judge_mesh(given, refined, photographs.images(), split);
}

TEST(MeshJudgement, TheMeshNearerToTheTruthIsBetter) {
  const Photographs photographs(ball(), 60, -0.98, true);
  const Mesh right = sphere_mesh(kRadius, 4), off = waved_ball(0.01 * 2 * kRadius);
  const LeftOutGain mended = judged(off, right, photographs);
  EXPECT_EQ(mended.images, 15u);
  EXPECT_GT(mended.gain_db, 3);
  EXPECT_TRUE(mended.refined_is_better());
  EXPECT_LT(judged(right, off, photographs).gain_db, -3);
}

TEST(MeshJudgement, PixelsThatARefinedMeshUncoversCountAgainstIt) {
  const Photographs photographs(ball(), 60, -0.98, true);
  const LeftOutGain shrunk = judged(sphere_mesh(kRadius, 4), sphere_mesh(0.97f * kRadius, 4), photographs);
  EXPECT_LT(shrunk.gain_db, -1);
  EXPECT_FALSE(shrunk.refined_is_better());
}

TEST(MeshJudgement, WithoutMasksAMeshThatIsTooLargeIsWorseThanTheRightOne) {
  const Photographs photographs(ball(), 60, -0.98, false);
  const Mesh right = sphere_mesh(kRadius, 4), large = sphere_mesh(1.1f * kRadius, 4);
  EXPECT_GT(judged(large, right, photographs).gain_db, 1) << "it shows the background where nothing is";
  const Mesh small = sphere_mesh(0.9f * kRadius, 4);
  EXPECT_LT(judged(right, small, photographs).gain_db, -1);
}

TEST(MeshJudgement, ARightMeshIsKeptAsItWasGivenAndAWrongOneIsNot) {
  const Photographs photographs(ball(), 48, -0.98, false);
  const JudgedMesh right = refine_and_judge(sphere_mesh(kRadius, 4), photographs.images());
  EXPECT_EQ(right.judgement.images, 6u);
  EXPECT_TRUE(right.kept_given());
  EXPECT_FALSE(refine_and_judge(waved_ball(0.01 * 2 * kRadius), photographs.images()).kept_given());
}

/// Pixels of masks that one mesh covers and another does not.
std::size_t uncovered(const Mesh& given, const Mesh& refined, const RefinementImages& images) {
  const RayScene given_scene(given), refined_scene(refined);
  SilhouetteCaster caster;
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < images.cameras.size(); ++i) {
    const ImageU8 mask = images.read(i).mask;
    const ImageU8 before = caster.cast(images.cameras[i], given, given_scene);
    const ImageU8 after = caster.cast(images.cameras[i], refined, refined_scene);
    for (std::size_t k = 0; k < mask.size(); ++k)
      pixels += mask.data()[k] != 0 && before.data()[k] != 0 && after.data()[k] == 0;
  }
  return pixels;
}

TEST(KeepOutlinesCovered, TakesBackWhatUncoversMasksAndNoMore) {
  const Photographs photographs(ball(), 40, -0.98, true);
  const Mesh given = sphere_mesh(kRadius, 4);
  // A cap that sank by one and a half pixels; the rest moved outward, which uncovers nothing.
  RefinedMesh refined{.mesh = given};
  for (std::size_t v = 0; v < given.vertices.size(); ++v) {
    const auto moved = static_cast<float>((given.vertices[v].x() > 0.5f * kRadius ? -1.5 : 0.2) * kPixel);
    refined.moved.push_back(moved);
    refined.mesh.vertices[v] += moved * given.vertices[v].normalized();
  }
  const RefinedMesh before = refined;
  const std::size_t lost = uncovered(given, before.mesh, photographs.images());
  ASSERT_GT(lost, 500u);
  const std::vector<float> footprints(given.vertices.size(), static_cast<float>(kPixel));
  keep_outlines_covered(given, photographs.images(), footprints, refined);
  EXPECT_LT(uncovered(given, refined.mesh, photographs.images()), lost / 100);
  for (std::size_t v = 0; v < given.vertices.size(); ++v) {
    EXPECT_GE(refined.moved[v], before.moved[v]);
    if (before.moved[v] < 0)
      EXPECT_LE(refined.moved[v], 0);
    else
      EXPECT_EQ(refined.moved[v], before.moved[v]);
  }
}

}  // namespace
}  // namespace sheen
