// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/small_files.h"

#include <chrono>

#include "reconstructor/models/surface_light_field/fill_unseen.h"

namespace sheen {

std::vector<SmallFileRow> study_small_files(const Experiment& experiment, const SurfaceLightFieldSnapshot& light_field,
                                            std::span<const double> losses_db) {
  const auto scores = [&](const ModelSnapshot& model) {
    return score(experiment.held_out, model,
                 RayPainter(model.mesh()));  // a small file has its triangles in another order
  };
  const std::shared_ptr<const SurfaceLightFieldSnapshot> model = fill_unseen(light_field);
  std::vector<SmallFileRow> rows;
  for (const double loss_db : losses_db) {
    const auto start = std::chrono::steady_clock::now();
    const CompressedModel small = model->compressed(
        {.bytes = {}, .loss_db = loss_db, .judge = [&](const ModelSnapshot& tried) { return scores(tried).psnr_db; }});
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    const Scores judged = scores(*small.snapshot);
    rows.push_back({loss_db, small.bytes, taken.count(), judged.psnr_db, judged.ssim});
  }
  return rows;
}

}  // namespace sheen
