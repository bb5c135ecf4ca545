// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/small_files.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>

#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

TEST(SmallFiles, TheMoreMayBeLostTheFewerBytesItTakes) {
  const std::vector<Capture> all =
      captures({square_object().surface, analytic::two_terms(0.1)}, analytic::eyes(32, 0.5, 0.55));
  const Experiment experiment =
      load_experiment(square_object().mesh, all.size(), [&](std::size_t i) { return all[i]; }, {});
  const OnlineRun run = build_online(experiment.mesh, experiment.in_order(), plain_options());
  const std::vector<SmallFileRow> rows = study_small_files(experiment, *run.model, std::array{0.2, 0.5, 2.0});
  ASSERT_EQ(rows.size(), 3u);
  const double exact = score(experiment.held_out, *fill_unseen(*run.model), *experiment.painter).psnr_db;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_LE(exact - rows[i].psnr_db, rows[i].asked_db + 1e-6) << i;
    EXPECT_GT(rows[i].bytes, 1000u);
    if (i == 0) continue;
    EXPECT_LT(rows[i].bytes, rows[i - 1].bytes);
    EXPECT_LT(rows[i].psnr_db, rows[i - 1].psnr_db);
  }
  const TempFolder folder;
  const CompressedModel small = fill_unseen(*run.model)->compressed({.bytes = 20e3});
  small.snapshot->save(folder.path() / "a.slf", {}, {});
  EXPECT_NEAR(static_cast<double>(std::filesystem::file_size(folder.path() / "a.slf")),
              static_cast<double>(small.bytes), 64);
}

}  // namespace
}  // namespace sheen
