// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/evaluate_lights.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/progress.h"
#include "common/datasets/light_list.h"
#include "reconstructor/commands/light_check.h"
#include "reconstructor/evaluation/evaluation_report.h"
#include "reconstructor/evaluation/held_out.h"

namespace sheen {

nlohmann::json evaluate_lights(const SavedModel& saved, const std::string& name, const std::filesystem::path& list,
                               bool told) {
  const LightList lights = load_light_list(list);
  require_light_kind(*saved.snapshot, lights.views, name, list);
  const std::unique_ptr<Baselines> baselines = origin_of(saved, name).settings->make_baselines(saved.snapshot, false);
  const RayPainter painter(saved.snapshot->mesh());
  std::vector<HeldOutView> views;
  Progress progress("reading", lights.views.size());
  for (std::size_t i = 0; i < lights.views.size(); ++i) {
    views.push_back(make_held_out_view(read_capture(lights, i), 1, painter));
    progress.update(i + 1);
  }
  const Scores scores = score(views, *saved.snapshot, painter),
               constant = score(views, *baselines->constant_colour(), painter);
  if (!told) return evaluation_report(scores, constant);
  for (const ViewScore& view : scores.views)
    std::printf("%s: %.2f dB, SSIM %.4f\n", view.name.c_str(), view.psnr_db, view.ssim);
  std::printf("mean over %zu lights: %.2f dB, SSIM %.4f; the same picture in every light: %.2f dB\n", views.size(),
              scores.psnr_db, scores.ssim, constant.psnr_db);
  return evaluation_report(scores, constant);
}

}  // namespace sheen
