// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

Scene glossy_scene() {
  return {square_object().surface, analytic::two_terms(0.2)};
}

TEST(Repetition, ASessionTenTimesAsLongOverTheSameViewsCostsTheSameMemory) {
  const std::vector<Capture> images = captures(glossy_scene(), eyes(30, 0.5, 0.55));
  SurfaceLightField model(square_object().mesh, plain_options());
  ingest_all(model, images);
  const std::size_t bytes = model.bytes();
  std::size_t updated = 0, skipped = 0;
  for (int turn = 0; turn < 8; ++turn)
    for (const Capture& image : images) {
      const IngestReport report = model.ingest(image);
      EXPECT_EQ(report.status, IngestStatus::kAccepted);
      updated += report.patches_updated;
      skipped += report.patches_skipped;
    }
  EXPECT_GT(skipped, 8 * 30 * 50u);
  EXPECT_LT(updated, (updated + skipped) / 20) << "a few are explained too badly to be called the same";
  EXPECT_LT(static_cast<double>(model.bytes()), 1.02 * static_cast<double>(bytes));
}

TEST(Repetition, ARepeatedViewThatShowsSomethingElseIsTakenIn) {
  const std::vector<Capture> images = captures(glossy_scene(), eyes(30, 0.5, 0.55));
  SurfaceLightField model(square_object().mesh, plain_options());
  ingest_all(model, images);
  for (const int image : {3, 29}) {  // the last one's columns wait to be folded
    const IngestReport same = model.ingest(images[image]);
    EXPECT_GT(same.patches_skipped, 0u) << image;
    EXPECT_EQ(same.patches_updated, 0u) << image;
  }
  const Scene other{square_object().surface, analytic::diffuse(0.03)};
  const IngestReport changed = model.ingest(captures(other, eyes(30, 0.5, 0.55))[3]);
  EXPECT_EQ(changed.patches_skipped, 0u);
  EXPECT_GT(changed.patches_updated, 50u);
}

TEST(Repetition, IsNotLookedForWithoutAnAngle) {
  const std::vector<Capture> images = captures(glossy_scene(), eyes(30, 0.5, 0.55));
  SurfaceLightFieldOptions options = plain_options();
  options.patch.repeat_angle = 0;
  SurfaceLightField model(square_object().mesh, options);
  ingest_all(model, images);
  EXPECT_EQ(model.ingest(images[3]).patches_skipped, 0u);
}

// Half of the 64 patches get the first image. The second one comes from elsewhere: patches that have seen nothing
// first.
TEST(Share, ThePatchesForWhichTheImageIsNewestAreUpdated) {
  const std::vector<Capture> images = captures(glossy_scene(), eyes(8, 0.5, 0.55));
  SurfaceLightField model(square_object().mesh, plain_options());
  model.set_update_fraction(0.5);
  const IngestReport first = model.ingest(images[0]);
  EXPECT_EQ(first.patches_left_out, 32u);
  const auto reached = [&] {
    const auto snapshot = model.light_field_snapshot();
    return std::count_if(snapshot->patches().begin(), snapshot->patches().end(),
                         [](const auto& patch) { return patch != nullptr; });
  };
  EXPECT_LE(reached(), 32);
  model.ingest(images[1]);
  EXPECT_GT(reached(), 56);
}

}  // namespace
}  // namespace sheen
