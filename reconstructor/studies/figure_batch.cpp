// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/format.h"
#include "common/image/color.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/studies/figure.h"

namespace sheen {
namespace {

constexpr double kPaperPsnr = 33.2;
constexpr double kGoalLoss = 0.1;  // dB, of held-out PSNR
constexpr std::size_t kRandomViews = 10;

/// PSNR between both models' pictures over the pixels that show the object's front, per view.
PlotSeries psnr_between(const Appearance& a, const Appearance& b, const std::vector<PosedCamera>& views,
                        const RayPainter& painter) {
  PlotSeries series{.name = "online against PCA"};
  for (const PosedCamera& view : views) {
    const auto picture = [&](const Appearance& model) {
      return to_srgb8(painter.paint(model, view.camera, view.camera_from_object).beauty);
    };
    ImageU8 front(view.camera.width, view.camera.height, 1);
    const std::vector<Hit> hits = painter.cast(view.camera, view.camera_from_object);
    std::transform(hits.begin(), hits.end(), front.data(), [](const Hit& hit) { return hit && hit.front; });
    series.add(static_cast<double>(series.x.size() + 1), squared_error(picture(a), picture(b), front).psnr_db());
  }
  return series;
}

}  // namespace

Figure figure_online_and_batch(const Experiment& experiment, const BatchRun& batch, const FigureOptions& options) {
  const OnlineRun online = build_online(experiment.mesh, experiment.in_order(), options.model);
  const auto online_model = fill_unseen(*online.model), batch_model = fill_unseen(*batch.model);
  Figure figure{.number = 8, .title = "Online and batch, side by side"};
  figure.paper = "PSNR between the pictures of PCA and of the online SVD: 33.2 dB, with some artifacts to be seen.";
  Plot plot{
      .title = "Online against batch PCA (figure 8)", .x = {.label = "held-out view"}, .y = {.label = "PSNR (dB)"}};
  plot.series = {{.name = "online against PCA"}, {.name = "online against truth"}, {.name = "PCA against truth"}};
  plot.levels.push_back({"the paper: online against PCA", kPaperPsnr});
  double between = 0, of_online = 0, of_batch = 0;
  const double views = static_cast<double>(experiment.held_out.size());
  for (std::size_t i = 0; i < experiment.held_out.size(); ++i) {
    const HeldOutView& view = experiment.held_out[i];
    const auto picture = [&](const Appearance& model) {
      return to_srgb8(experiment.painter->paint(model, view.camera, view.camera_from_object).beauty);
    };
    const ImageU8 a = picture(*online_model), b = picture(*batch_model);
    const JudgedPixels judged = view.pixels();
    const double psnr[] = {squared_error(a, b, judged.object).psnr_db(),
                           squared_error(a, judged.truth, judged.object).psnr_db(),
                           squared_error(b, judged.truth, judged.object).psnr_db()};
    for (std::size_t k = 0; k < 3; ++k) plot.series[k].add(static_cast<double>(i + 1), psnr[k]);
    between += psnr[0] / views;
    of_online += psnr[1] / views;
    of_batch += psnr[2] / views;
    if (i != experiment.held_out.size() / 2) continue;
    figure.pictures.push_back({"figure_08_batch", "batch PCA", b});
    figure.pictures.push_back({"figure_08_online", "online", a});
    figure.pictures.push_back({"figure_08_truth", "photograph", judged.truth});
  }
  Plot random{.title = "Online against batch PCA at random viewpoints (figure 8)",
              .x = {.label = "viewpoint"},
              .y = {.label = "PSNR (dB)"}};
  random.series.push_back(psnr_between(*online_model, *batch_model,
                                       random_viewpoints(experiment, kRandomViews, options.seed), *experiment.painter));
  random.levels.push_back({"the paper: online against PCA", kPaperPsnr});
  const std::vector<double>& at_random = random.series.front().y;
  const double mean_at_random = std::accumulate(at_random.begin(), at_random.end(), 0.0) / kRandomViews;
  figure.ours = format(
      "Rank %d, views that neither saw: %.1f dB between the two; at %zu random viewpoints of the hemisphere round the "
      "object %.1f dB, at least %.1f dB. Held-out PSNR: online %.2f dB, batch %.2f dB.",
      options.rank, between, kRandomViews, mean_at_random, *std::min_element(at_random.begin(), at_random.end()),
      of_online, of_batch);
  figure.holds = between >= kPaperPsnr && mean_at_random >= kPaperPsnr && of_batch - of_online <= kGoalLoss;
  figure.plots.push_back({"figure_08_online_and_batch", std::move(plot)});
  figure.plots.push_back({"figure_08_random_viewpoints", std::move(random)});
  return figure;
}

}  // namespace sheen
