// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>

#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/effort/resident_memory.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

/// Large enough to tell: some hundred megabytes beside a program of some ten.
class ResidentMemoryTest : public ::testing::Test {
 protected:
  void SetUp() override {
#ifdef __has_feature  // clang, which builds with sanitizers
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
    GTEST_SKIP() << "a sanitizer has memory of its own";
#endif
#endif
  }
  ResidentMemoryTest() {
    options_.hold_out_every = 4;
    options_.surface_map = 18;
    options_.map_detail = 0;  // so that there is much to be counted
    options_.patch.factor.tolerance = 0;
    images_ = captures({analytic::sphere(0.09), analytic::two_terms(0.02)}, analytic::eyes(40, 0.5, -0.9));
    malloc_trim(0);  // what earlier tests have left would be taken again, and nothing would grow
  }
  /// As `serve` does it: one snapshot is shown while the next is made.
  void ingest_next(Reconstruction& reconstruction) {
    for (const Capture& image : images_) {
      reconstruction.ingest(image);
      const auto next = reconstruction.snapshot();
      shown_ = next;
    }
  }

  const Mesh mesh_ = sphere_mesh(0.09f, 4);
  SurfaceLightFieldOptions options_;
  std::vector<Capture> images_;
  std::shared_ptr<const ModelSnapshot> shown_;
};

TEST_F(ResidentMemoryTest, ThePartsAddUpToWhatTheProcessHasGrownBy) {
  Reconstruction reconstruction(mesh_, options_);
  ingest_next(reconstruction);
  const MemoryAccount account = reconstruction.memory();
  const double grown = reconstruction.resident_growth();
  double sum = 0;
  for (const auto& [part, bytes] : account.parts()) {
    std::printf("%-10s %8.1f MB\n", part.c_str(), bytes / 1e6);
    sum += bytes;
  }
  std::printf("counted %.1f MB, the process has grown by %.1f MB\n", sum / 1e6, grown / 1e6);
  EXPECT_EQ(sum, account.total());
  const auto snapshot = static_cast<double>(shown_->memory_bytes());
  std::printf("a snapshot: counted %.1f MB, it keeps %.1f MB\n", account.snapshots / 2e6, snapshot / 1e6);
  EXPECT_NEAR(account.snapshots / 2, snapshot, 0.15 * snapshot);
  ASSERT_GT(grown, 150e6);
  const double counted = sum - MemoryAccount::kProgram;  // which was there before
  EXPECT_GT(counted, 0.8 * grown);
  EXPECT_LT(counted, 1.1 * grown);
}

TEST_F(ResidentMemoryTest, ALimitHoldsForTheProcess) {
  Reconstruction reconstruction(mesh_, options_);
  const double asked = 120e6;
  reconstruction.keep_within({.bytes = asked});
  ingest_next(reconstruction);
  const double grown = reconstruction.resident_growth();
  std::printf("asked %.1f MB, counted %.1f MB, the process has grown by %.1f MB\n", asked / 1e6,
              reconstruction.memory().total() / 1e6, grown / 1e6);
  EXPECT_LE(reconstruction.memory().total(), asked);
  EXPECT_GT(reconstruction.memory().total(), 0.4 * asked);
  EXPECT_LE(grown, 1.2 * asked) << "what the allocator keeps beside it";
}

}  // namespace
}  // namespace sheen
