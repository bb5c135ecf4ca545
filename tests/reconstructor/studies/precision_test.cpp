// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/precision.h"

#include <gtest/gtest.h>

#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

TEST(Precision, EachFormatRoundsAsItsDigitsSay) {
  std::vector<Capture> all =
      captures({square_object().surface, analytic::two_terms(0.2)}, analytic::eyes(24, 0.5, 0.55));
  for (std::size_t i = 0; i < all.size(); ++i) all[i].sequence = i + 1;
  const Experiment experiment =
      load_experiment(square_object().mesh, all.size(), [&](std::size_t i) { return all[i]; }, {});
  const SurfaceLightFieldOptions options = plain_options();
  const OnlineRun run = build_online(experiment.mesh, experiment.in_order(), options);
  const PrecisionStudy study = study_precision(experiment, options, *run.model);
  EXPECT_GT(study.patches, 0u);
  EXPECT_GE(study.columns, study.patches);

  EXPECT_EQ(study.twice.difference, 0);
  EXPECT_GT(study.single.difference, 0);
  EXPECT_LT(study.single.difference, 1e-4);
  EXPECT_GT(study.stored_half.difference, 1e-5) << "11 bits: 2^-12 at most, a value";
  EXPECT_LT(study.stored_half.difference, 1e-3);
  EXPECT_NEAR(study.single.relative_error, study.twice.relative_error, 1e-4);
  EXPECT_EQ(study.stored.relative_error, study.single.relative_error);
  EXPECT_DOUBLE_EQ(2 * study.stored_half.patch_bytes, study.stored.patch_bytes);
  EXPECT_GT(study.twice.patch_bytes, 1.3 * study.single.patch_bytes);
  EXPECT_LT(study.stored.patch_bytes, study.single.patch_bytes);
  EXPECT_NEAR(study.psnr_half_db, study.psnr_db, 0.1);
}

}  // namespace
}  // namespace sheen
