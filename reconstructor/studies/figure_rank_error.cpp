// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>

#include "common/base/format.h"
#include "reconstructor/studies/figure.h"
#include "reconstructor/studies/patch_sample.h"

namespace sheen {

Figure figure_rank_error(const BatchRun& batch, const FigureOptions& options) {
  const std::vector<PatchMatrix> patches = whole_patches(*batch.columns, 16, options.quick ? 100 : 400);
  Figure figure{.number = 4, .title = "Error against rank"};
  figure.paper =
      "The online SVD has more error than PCA at the same rank; computed at twice the rank, of which the largest are "
      "used, it has less (Brand).";
  if (patches.empty()) {
    figure.ours = "No patch is seen whole by 16 images.";
    figure.holds = false;
    return figure;
  }
  std::vector<std::uint32_t> taken(batch.columns->images());
  std::iota(taken.begin(), taken.end(), 0u);
  const std::vector<std::vector<int>> orders = orders_by_image(patches, taken);

  PlotSeries pca{.name = "PCA"}, capped{.name = "online, same rank inside"},
      doubled{.name = "online, twice the rank inside"};
  double worst_capped = 0, worst_doubled = 0;
  for (const int rank : {1, 2, 3, 4, 5, 6, 8, 10, 12}) {
    if (options.quick && rank > 6) break;
    const double best = batch_error(patches, rank);
    const double same = online_error(patches, orders, {.max_rank = rank, .internal_rank = rank, .tolerance = 0});
    const double twice = online_error(patches, orders, {.max_rank = rank, .internal_rank = 2 * rank, .tolerance = 0});
    pca.add(rank, best);
    capped.add(rank, same);
    doubled.add(rank, twice);
    worst_capped = std::max(worst_capped, same / best);
    worst_doubled = std::max(worst_doubled, twice / best);
  }
  figure.ours = format(
      "%zu patches, images in the order they were taken: error over PCA's at most %.3f with the same rank inside and "
      "%.4f "
      "with twice the rank inside.",
      patches.size(), worst_capped, worst_doubled);
  figure.holds = worst_doubled < worst_capped && worst_doubled < 1.01;
  Plot plot{.title = "Error against rank (figure 4)",
            .x = {.label = "rank"},
            .y = {.label = "relative error of all patches"}};
  plot.series = {std::move(capped), std::move(doubled), std::move(pca)};
  plot.series.back().style = PlotStyle::kDashed;
  figure.plots.push_back({"figure_04_rank_error", std::move(plot)});
  return figure;
}

}  // namespace sheen
