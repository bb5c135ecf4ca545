// SPDX-License-Identifier: Apache-2.0
// What those who watch are shown of the trade between time, memory and accuracy.
#include "common/capture/trade.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reconstructor/capture/live_display.h"
#include "reconstructor/capture/reconstruction.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

std::vector<Capture> glossy_captures(int count) {
  return captures({square_object().surface, analytic::two_terms(0.06)}, analytic::eyes(count, 0.5, 0.55));
}

TEST(Trade, ABudgetThatNoMachineKeepsIsNotKept) {
  Reconstruction hurried(*square_object().mesh, plain_options());
  hurried.keep_within({.image_ms = 1e-9, .favour = "speed"});
  EXPECT_FALSE(hurried.trade({}).budget_kept()) << "no image says yet";
  for (const Capture& image : glossy_captures(16)) hurried.ingest(image);
  const Trade trade = hurried.trade({});
  EXPECT_EQ(trade.budget_kept(), false);
  EXPECT_GT(trade.image_ms, 0);
  EXPECT_EQ(trade.effort_level, hurried.effort().level);
  EXPECT_EQ(trade.update_fraction, hurried.effort().update_fraction);
  EXPECT_EQ(trade.effort_levels, SurfaceLightFieldOptions{}.effort_levels());
  EXPECT_EQ(trade.favour, "speed");
  EXPECT_FALSE(trade.memory_kept()) << "nobody asked";
}

TEST(Trade, MemoryIsOfTheProcessBesideWhatWasAskedFor) {
  Reconstruction reconstruction(*square_object().mesh, plain_options());
  reconstruction.keep_within({.image_ms = 1e9, .bytes = 1e12});
  for (const Capture& image : glossy_captures(4)) reconstruction.ingest(image);
  const Trade trade = reconstruction.trade({.orthogonality_lost = 1e-5, .energy_lost = 0.01});
  EXPECT_EQ(trade.budget_kept(), true);
  EXPECT_EQ(trade.memory_kept(), true);
  EXPECT_GT(trade.resident_bytes, 1e6);
  EXPECT_LT(trade.grown_bytes, trade.resident_bytes) << "the program was there before";
  EXPECT_EQ(trade.health.energy_lost, 0.01);
}

TEST(Trade, IsOnThePageAndInTheWindow) {
  LiveDisplay display({});
  LoopStatus status;
  status.trade = {.effort_level = 3, .effort_levels = 6, .update_fraction = 0.35, .image_ms = 40, .budget_ms = 33};
  display.publish_to_window(status);
  const Trade window = display.feed().latest()->figures->trade, page = display.monitor_state(status).trade;
  for (const Trade& shown : {window, page}) {
    EXPECT_EQ(shown.effort_level, 3);
    EXPECT_EQ(shown.update_fraction, 0.35);
    EXPECT_EQ(shown.budget_kept(), false);
  }
}

TEST(Trade, AModelSaysHowSoundlyItHoldsWhatImagesGave) {
  const Object object = sphere_object();
  const analytic::Scene scene{object.surface, analytic::two_terms(0.1)};
  SurfaceLightFieldOptions exact = plain_options(), rough = plain_options();
  exact.patch.factor.tolerance = 0;
  rough.patch.factor.tolerance = 0.2;
  const auto health_of = [&](const SurfaceLightFieldOptions& options) {
    SurfaceLightField model(object.mesh, options);
    EXPECT_TRUE(std::isnan(model.health().energy_lost)) << "no image has come";
    ingest_all(model, captures(scene, analytic::eyes(40, 0.5, 0.2)));
    const NumericalHealth health = model.health();
    model.finish();
    EXPECT_EQ(model.health().energy_lost, health.energy_lost) << "as long as there is a model";
    return health;
  };
  const NumericalHealth kept = health_of(exact), dropped = health_of(rough);
  for (const NumericalHealth& health : {kept, dropped}) {
    EXPECT_GT(health.orthogonality_lost, 0) << "measured, not claimed";
    EXPECT_LT(health.orthogonality_lost, 2e-3) << "of 16 bits a value";
  }
  EXPECT_LT(kept.energy_lost, 1e-3);
  EXPECT_GT(dropped.energy_lost, 2 * kept.energy_lost);
  EXPECT_LT(dropped.energy_lost, 0.2 * 0.2) << "the tolerance is of norms";
}

TEST(Demand, IsOfEachTriangleAndAddsUpToItsPatch) {
  const Object object = sphere_object();
  const analytic::Scene scene{object.surface, analytic::two_terms(0.1)};
  SurfaceLightField model(object.mesh, plain_options());
  const auto nothing = model.light_field_snapshot()->demand();
  ASSERT_EQ(nothing.size(), object.mesh->triangles.size());
  for (const SurfaceDemand& triangle : nothing) EXPECT_EQ(triangle.rank, 0);
  ingest_all(model, captures(scene, analytic::eyes(16, 0.5, 0.1)));  // from one side
  const auto snapshot = model.light_field_snapshot();
  const std::vector<SurfaceDemand> demand = snapshot->demand();
  double bytes = 0, of_patches = 0;
  std::size_t unseen = 0;
  for (std::size_t t = 0; t < demand.size(); ++t) {
    const auto patch = snapshot->patch(snapshot->place(t).patch);
    EXPECT_EQ(demand[t].rank, patch ? patch->rank() : 0);
    EXPECT_EQ(demand[t].resolution, demand[t].rank > 0 ? snapshot->maps().resolution(t) : 0);
    bytes += demand[t].bytes;
    unseen += demand[t].rank == 0;
  }
  for (const auto& patch : snapshot->patches())
    if (patch && patch->rank() > 0) of_patches += static_cast<double>(patch->bytes());
  EXPECT_NEAR(bytes, of_patches, 1e-4 * of_patches) << "shared by the triangles of each patch";
  EXPECT_GT(unseen, 0u);
  EXPECT_LT(unseen, demand.size());
}

}  // namespace
}  // namespace sheen
