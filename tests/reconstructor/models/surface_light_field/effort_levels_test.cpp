// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/effort_levels.h"

#include <gtest/gtest.h>

#include <tuple>

#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

TEST(EffortLevels, NoneAsksForMoreThanTheOneBefore) {
  const SurfaceLightFieldOptions asked = plain_options();
  SurfaceLightFieldOptions before = at_effort_level(asked, 0);
  EXPECT_EQ(before.map_scale, asked.map_scale);
  EXPECT_EQ(before.patch.factor.max_rank, asked.patch.factor.max_rank);
  for (std::size_t r = 1; r < all_effort_levels().size(); ++r) {
    const SurfaceLightFieldOptions at = at_effort_level(asked, static_cast<int>(r));
    EXPECT_LE(at.map_scale, before.map_scale);
    EXPECT_LE(at.patch.factor.max_rank, before.patch.factor.max_rank);
    EXPECT_LE(at.patch.factor.terms_kept(), before.patch.factor.terms_kept());
    EXPECT_NE(std::make_tuple(at.map_scale, at.patch.factor.max_rank, at.patch.factor.terms_kept()),
              std::make_tuple(before.map_scale, before.patch.factor.max_rank, before.patch.factor.terms_kept()));
    before = at;
  }
}

}  // namespace
}  // namespace sheen
