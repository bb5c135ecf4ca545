// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "common/base/format.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/studies/figure.h"
#include "reconstructor/studies/patch_sample.h"

namespace sheen {
namespace {

// A light field for each order is what takes the time: of the random ones, so many are built.
constexpr std::size_t kRandomForPsnr = 4;

struct Order {
  std::string name;
  std::vector<std::uint32_t> images;
};

/// The images by what they show of the object: sum of squares of all columns.
std::vector<std::uint32_t> by_norm(const BatchLightField& light_field) {
  std::vector<double> energy(light_field.images(), 0);
  for (std::size_t v = 0; v < light_field.patches(); ++v) {
    const PatchMatrix patch = light_field.patch(v);
    for (int j = 0; j < patch.views(); ++j)
      energy[patch.images[static_cast<std::size_t>(j)]] += patch.columns.col(j).squaredNorm();
  }
  std::vector<std::uint32_t> order(energy.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return energy[a] < energy[b]; });
  return order;
}

std::vector<Order> image_orders(const BatchLightField& light_field, int random, std::uint64_t seed) {
  std::vector<std::uint32_t> sorted = by_norm(light_field);
  std::vector<Order> orders;
  std::mt19937_64 generator(seed);
  for (int k = 0; k < random; ++k) {
    std::vector<std::uint32_t> shuffled = sorted;
    std::shuffle(shuffled.begin(), shuffled.end(), generator);
    orders.push_back({"random", std::move(shuffled)});
  }
  std::vector<std::uint32_t> taken = sorted;
  std::sort(taken.begin(), taken.end());
  orders.push_back({"as taken", std::move(taken)});
  orders.push_back({"sorted, rising", sorted});
  std::reverse(sorted.begin(), sorted.end());
  orders.push_back({"sorted, falling", std::move(sorted)});
  return orders;
}

}  // namespace

Figure figure_orders(const Experiment& experiment, const BatchRun& batch, const FigureOptions& options) {
  const std::vector<Order> orders = image_orders(*batch.columns, options.quick ? 4 : 20, options.seed);
  const std::vector<PatchMatrix> patches = whole_patches(*batch.columns, 16, options.quick ? 100 : 400);
  const OnlineSvdOptions paper{.max_rank = options.rank, .internal_rank = options.rank, .tolerance = 0};
  const OnlineSvdOptions ours{.max_rank = options.rank, .internal_rank = 2 * options.rank, .tolerance = 0};
  const double best = batch_error(patches, options.rank);
  const std::vector<PatchMatrix> holed = patches_with_holes(*batch.columns, 16, options.quick ? 30 : 100);
  const double best_surprise = batch_surprise(holed, options.rank);

  Plot error{.title = format("Total error of %zu orders (figure 11)", orders.size()),
             .x = {.label = "order of the images"},
             .y = {.label = format("relative error of all patches, rank %d", options.rank)}};
  error.levels.push_back({"PCA", best});
  error.series.push_back({.name = "online, same rank inside", .style = PlotStyle::kMarkers});
  error.series.push_back({.name = "online, twice the rank inside", .style = PlotStyle::kMarkers});
  Plot unlikely{.title = format("Patches with missing values in %zu orders (figure 11)", orders.size()),
                .x = {.label = "order of the images"},
                .y = {.label = "-log likelihood of known values (nats per value)"}};
  unlikely.levels.push_back({"batch, missing values by expectation maximisation", best_surprise});
  unlikely.series.push_back({.name = "online, same rank inside", .style = PlotStyle::kMarkers});
  unlikely.series.push_back({.name = "online, twice the rank inside", .style = PlotStyle::kMarkers});
  Plot worth{.title = "Held-out PSNR and the order of the images (figure 11)",
             .x = {.label = "order of the images"},
             .y = {.label = "held-out PSNR (dB)"}};
  worth.levels.push_back({"batch", batch.psnr_db});
  worth.series.push_back({.name = "online light field", .style = PlotStyle::kMarkers});
  double worst_error = 0, least_error = 1e9, worst_capped = 0, worst_psnr = 1e9, best_psnr = 0;
  double worst_surprise = -1e9, least_surprise = 1e9;
  for (std::size_t k = 0; k < orders.size(); ++k) {
    const std::string& name = orders[k].name;
    const std::string label = name == "random" ? "" : name;
    const auto columns = name == "sorted, rising"    ? orders_by_norm(patches, true)
                         : name == "sorted, falling" ? orders_by_norm(patches, false)
                                                     : orders_by_image(patches, orders[k].images);
    const double at = static_cast<double>(k + 1);
    const double capped = online_error(patches, columns, paper), doubled = online_error(patches, columns, ours);
    error.series[0].add(at, capped);
    error.series[1].add(at, doubled);
    error.series[0].labels.push_back(label);
    error.series[1].labels.push_back("");
    worst_capped = std::max(worst_capped, capped);
    worst_error = std::max(worst_error, doubled);
    least_error = std::min({least_error, capped, doubled});
    if (!holed.empty()) {
      const auto visits = orders_by_image(holed, orders[k].images);
      const double of_capped = online_surprise(holed, visits, paper), of_doubled = online_surprise(holed, visits, ours);
      unlikely.series[0].add(at, of_capped);
      unlikely.series[1].add(at, of_doubled);
      unlikely.series[0].labels.push_back(label);
      unlikely.series[1].labels.push_back("");
      worst_surprise = std::max(worst_surprise, of_doubled);
      least_surprise = std::min({least_surprise, of_capped, of_doubled});
    }

    if (!label.empty() || k < kRandomForPsnr) {
      std::vector<const Capture*> captures;
      for (const std::uint32_t i : orders[k].images) captures.push_back(&experiment.training[i]);
      const OnlineRun run = build_online(experiment.mesh, captures, options.model);
      const double psnr = mean_psnr_db(experiment.held_out, *fill_unseen(*run.model), *experiment.painter);
      worth.series[0].add(at, psnr);
      worth.series[0].labels.push_back(label);
      worst_psnr = std::min(worst_psnr, psnr);
      best_psnr = std::max(best_psnr, psnr);
    }
  }
  Figure figure{.number = 11, .title = "Order of the images"};
  figure.paper = "Random orders have more error than PCA and differ; the one sorted by norm is the worst.";
  const std::string errors =
      patches.empty() ? "No patch is seen whole by 16 images."
                      : format("Error over PCA's in the worst: %.3f with the same rank inside, %.4f with twice.",
                               worst_capped / best, worst_error / best);
  const std::string likelihoods =
      holed.empty() ? ""
                    : format(
                          " Patches with missing values, -log likelihood of what is known beyond batch's: %.4f to %.4f "
                          "nats per value.",
                          least_surprise - best_surprise, worst_surprise - best_surprise);
  const double behind = batch.psnr_db - worst_psnr;
  figure.ours = format(
      "Rank %d, %zu orders. %s%s Held-out PSNR in %zu of them %.2f to %.2f dB, batch %.2f dB: the worst order is %.2f "
      "dB %s (goal: at "
      "most 0.1 dB behind).",
      options.rank, orders.size(), errors.c_str(), likelihoods.c_str(), worth.series[0].x.size(), worst_psnr, best_psnr,
      batch.psnr_db, std::abs(behind), behind > 0 ? "behind" : "ahead");
  constexpr double kRounding = 1e-6;
  const bool never_ahead = (patches.empty() || least_error >= best * (1 - kRounding)) &&
                           (holed.empty() || least_surprise >= best_surprise - kRounding);
  figure.holds = never_ahead && behind <= 0.1;
  if (!patches.empty()) figure.plots.push_back({"figure_11_orders_error", std::move(error)});
  if (!holed.empty()) figure.plots.push_back({"figure_11_orders_likelihood", std::move(unlikely)});
  figure.plots.push_back({"figure_11_orders_psnr", std::move(worth)});
  return figure;
}

}  // namespace sheen
