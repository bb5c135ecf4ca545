// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
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

constexpr const char* kRandom = "random";
constexpr const char* kRising = "sorted, rising";
constexpr const char* kFalling = "sorted, falling";

struct Order {
  std::string name;
  std::vector<std::uint32_t> images;

  std::string label() const { return name == kRandom ? "" : name; }
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
    orders.push_back({kRandom, std::move(shuffled)});
  }
  std::vector<std::uint32_t> taken = sorted;
  std::sort(taken.begin(), taken.end());
  orders.push_back({"as taken", std::move(taken)});
  orders.push_back({kRising, sorted});
  std::reverse(sorted.begin(), sorted.end());
  orders.push_back({kFalling, std::move(sorted)});
  return orders;
}

std::vector<std::vector<int>> columns_in(const Order& order, const std::vector<PatchMatrix>& patches) {
  if (order.name == kRising) return orders_by_norm(patches, true);
  if (order.name == kFalling) return orders_by_norm(patches, false);
  return orders_by_image(patches, order.images);
}

/// A plot over the orders: a series of markers for each way of factorizing, and the level that batch reaches.
struct OrderPlot {
  Plot plot;
  double batch = 0;

  OrderPlot(std::string title, std::string y, PlotLevel level, const std::vector<std::string>& series)
      : plot{.title = std::move(title), .x = {.label = "order of the images"}, .y = {.label = std::move(y)}},
        batch(level.y) {
    plot.levels.push_back(std::move(level));
    for (const std::string& name : series) plot.series.push_back({.name = name, .style = PlotStyle::kMarkers});
  }

  /// The first series is labelled: where two have much the same value, labels would lie on each other.
  void add(std::size_t order, const std::string& label, const std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      plot.series[i].add(static_cast<double>(order + 1), values[i]);
      plot.series[i].labels.push_back(i == 0 ? label : "");
    }
  }

  bool empty() const { return plot.series[0].y.empty(); }
  double most(std::size_t series) const { return *std::ranges::max_element(plot.series[series].y); }
  double least() const {
    double least = std::numeric_limits<double>::infinity();
    for (const PlotSeries& series : plot.series)
      for (const double y : series.y) least = std::min(least, y);
    return least;
  }
};

/// Online factorizations of a rank, which keep as many terms inside, or twice as many.
struct Ranks {
  OnlineSvdOptions same, twice;
  explicit Ranks(int rank)
      : same{.max_rank = rank, .internal_rank = rank, .tolerance = 0},
        twice{.max_rank = rank, .internal_rank = 2 * rank, .tolerance = 0} {}
  static std::vector<std::string> names() { return {"online, same rank inside", "online, twice the rank inside"}; }
};

OrderPlot errors_of(const std::vector<Order>& orders, const std::vector<PatchMatrix>& patches, int rank) {
  OrderPlot plot(format("Total error of %zu orders (figure 11)", orders.size()),
                 format("relative error of all patches, rank %d", rank), {"PCA", batch_error(patches, rank)},
                 Ranks::names());
  const Ranks ranks(rank);
  for (std::size_t k = 0; k < orders.size() && !patches.empty(); ++k) {
    const auto columns = columns_in(orders[k], patches);
    plot.add(k, orders[k].label(),
             {online_error(patches, columns, ranks.same), online_error(patches, columns, ranks.twice)});
  }
  return plot;
}

OrderPlot surprises_of(const std::vector<Order>& orders, const std::vector<PatchMatrix>& holed, int rank) {
  OrderPlot plot(format("Patches with missing values in %zu orders (figure 11)", orders.size()),
                 "-log likelihood of known values (nats per value)",
                 {"batch, missing values by expectation maximisation", batch_surprise(holed, rank)}, Ranks::names());
  const Ranks ranks(rank);
  for (std::size_t k = 0; k < orders.size() && !holed.empty(); ++k) {
    const auto columns = orders_by_image(holed, orders[k].images);
    plot.add(k, orders[k].label(),
             {online_surprise(holed, columns, ranks.same), online_surprise(holed, columns, ranks.twice)});
  }
  return plot;
}

OrderPlot psnrs_of(const std::vector<Order>& orders, const Experiment& experiment, double batch_db,
                   const SurfaceLightFieldOptions& model) {
  OrderPlot plot("Held-out PSNR and the order of the images (figure 11)", "held-out PSNR (dB)", {"batch", batch_db},
                 {"online light field"});
  for (std::size_t k = 0; k < orders.size(); ++k) {
    if (orders[k].label().empty() && k >= kRandomForPsnr) continue;
    std::vector<const Capture*> captures;
    for (const std::uint32_t i : orders[k].images) captures.push_back(&experiment.training[i]);
    const OnlineRun run = build_online(experiment.mesh, captures, model);
    plot.add(k, orders[k].label(), {mean_psnr_db(experiment.held_out, *fill_unseen(*run.model), *experiment.painter)});
  }
  return plot;
}

}  // namespace

Figure figure_orders(const Experiment& experiment, const BatchRun& batch, const FigureOptions& options) {
  const std::vector<Order> orders = image_orders(*batch.columns, options.quick ? 4 : 20, options.seed);
  OrderPlot error = errors_of(orders, whole_patches(*batch.columns, 16, options.quick ? 100 : 400), options.rank);
  OrderPlot unlikely =
      surprises_of(orders, patches_with_holes(*batch.columns, 16, options.quick ? 30 : 100), options.rank);
  OrderPlot psnr = psnrs_of(orders, experiment, batch.psnr_db, options.model);

  Figure figure{.number = 11, .title = "Order of the images"};
  figure.paper = "Random orders have more error than PCA and differ; the one sorted by norm is the worst.";
  const std::string errors =
      error.empty() ? "No patch is seen whole by 16 images."
                    : format("Error over PCA's in the worst: %.3f with the same rank inside, %.4f with twice.",
                             error.most(0) / error.batch, error.most(1) / error.batch);
  const std::string likelihoods =
      unlikely.empty() ? ""
                       : format(
                             " Patches with missing values, -log likelihood of what is known beyond batch's: %.4f "
                             "to %.4f nats per value.",
                             unlikely.least() - unlikely.batch, unlikely.most(1) - unlikely.batch);
  const double behind = batch.psnr_db - psnr.least();
  figure.ours = format(
      "Rank %d, %zu orders. %s%s Held-out PSNR in %zu of them %.2f to %.2f dB, batch %.2f dB: the worst order is %.2f "
      "dB %s (goal: at most 0.1 dB behind).",
      options.rank, orders.size(), errors.c_str(), likelihoods.c_str(), psnr.plot.series[0].x.size(), psnr.least(),
      psnr.most(0), batch.psnr_db, std::abs(behind), behind > 0 ? "behind" : "ahead");
  constexpr double kRounding = 1e-6;
  const bool never_ahead = (error.empty() || error.least() >= error.batch * (1 - kRounding)) &&
                           (unlikely.empty() || unlikely.least() >= unlikely.batch - kRounding);
  figure.holds = never_ahead && behind <= 0.1;
  if (!error.empty()) figure.plots.push_back({"figure_11_orders_error", std::move(error.plot)});
  if (!unlikely.empty()) figure.plots.push_back({"figure_11_orders_likelihood", std::move(unlikely.plot)});
  figure.plots.push_back({"figure_11_orders_psnr", std::move(psnr.plot)});
  return figure;
}

}  // namespace sheen
