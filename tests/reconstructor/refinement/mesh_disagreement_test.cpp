// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/mesh_disagreement.h"

#include <gtest/gtest.h>

#include "tests/reconstructor/refinement/ball_photographs.h"

namespace sheen {
namespace {

TEST(MeshDisagreement, ARightMeshHasNoneAndAWavedOneAsMuchAsItsWaves) {
  const Photographs photographs(ball(), 48, -0.98, true);
  const MeshDisagreement right = measure_disagreement(sphere_mesh(kRadius, 4), photographs.images());
  EXPECT_GT(right.observed, right.looked_at / 2);
  EXPECT_LT(right.off_px, 0.5);
  EXPECT_LT(right.gain_db, 0.1);
  const double waves = 0.02 * kRadius;
  const MeshDisagreement waved = measure_disagreement(waved_ball(waves), photographs.images());
  EXPECT_NEAR(waved.off_px, waves / kPixel, 0.5 * waves / kPixel);
  EXPECT_GT(waved.gain_db, 0.5);
}

TEST(MeshDisagreement, AnotherObjectsMeshIsHardlyObserved) {
  const Photographs photographs(ball(), 48, -0.98, true);
  Mesh other = sphere_mesh(0.4f * kRadius, 4);
  for (Eigen::Vector3f& v : other.vertices) v.z() += 0.02f;
  const MeshDisagreement found = measure_disagreement(other, photographs.images());
  EXPECT_LT(found.observed, found.looked_at / 50);
}

}  // namespace
}  // namespace sheen
