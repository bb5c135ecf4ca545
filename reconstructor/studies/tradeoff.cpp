// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/tradeoff.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "common/base/format.h"
#include "reconstructor/models/surface_light_field/effort_levels.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"

namespace sheen {
namespace {

/// By which factor a point exceeds what is allowed; 1 when it does not.
double excess(const TradeoffPoint& point, const Limits& limits) {
  double factor = 1;
  if (limits.image_ms) factor = std::max(factor, point.image_ms / *limits.image_ms);
  if (limits.bytes) factor = std::max(factor, point.bytes / *limits.bytes);
  return factor;
}

}  // namespace

std::vector<Setting> tradeoff_settings(const SurfaceLightFieldOptions& base, bool quick) {
  std::vector<Setting> settings{{"default", "default", base}};
  const auto add = [&](const char* part, const std::string& name, const auto& set) {
    Setting setting{name, part, base};
    set(setting.options);
    settings.push_back(std::move(setting));
  };
  const auto vary = [&](const char* part, const char* key, const auto& values, const auto& set) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (quick && i % 2 == 1) continue;
      add(part, format("%s = %g", key, static_cast<double>(values[i])),
          [&](SurfaceLightFieldOptions& o) { set(o, values[i]); });
    }
  };
  using Options = SurfaceLightFieldOptions;
  const auto set_rank = [](Options& o, int rank) {
    o.patch.factor.max_rank = rank;
    if (o.patch.factor.internal_rank < rank) o.patch.factor.internal_rank = 0;
  };
  vary("rank", "max_rank", std::vector{2, 4, 6, 9, 12, 18, 32}, set_rank);
  vary("internal rank", "max_rank = 6, internal_rank", std::vector{6, 9, 12, 20}, [&](Options& o, int v) {
    o.patch.factor.max_rank = 6;
    o.patch.factor.internal_rank = v;
  });
  vary("tolerance", "tolerance", std::vector{0.0, 0.005, 0.02, 0.04, 0.08},
       [](Options& o, double v) { o.patch.factor.tolerance = v; });
  vary("surface map", "surface_map", std::vector{4, 6, 8, 12, 16}, [](Options& o, int v) { o.surface_map = v; });
  vary("surface map", "map_scale", std::vector{0.5, 0.7, 1.4}, [](Options& o, double v) { o.map_scale = v; });
  vary("surface map", "map_detail", std::vector{0.0, 0.2, 0.1}, [](Options& o, double v) { o.map_detail = v; });
  vary("sampling", "sampling = linear, map_scale", std::vector{1.0, 0.7}, [](Options& o, double v) {
    o.sampling = Sampling::kLinear;
    o.map_scale = v;
  });
  vary("block", "block", std::vector{1, 4, 24}, [](Options& o, int v) { o.patch.factor.block = v; });
  vary("views", "max_views", std::vector{16, 32, 128}, [](Options& o, int v) { o.patch.max_views = v; });
  vary("repetitions", "repeat_angle", std::vector{0.0, 0.06}, [](Options& o, double v) { o.patch.repeat_angle = v; });
  vary("imputation", "min_visible", std::vector{0.5, 0.02, 1.0, 0.3},
       [](Options& o, double v) { o.patch.min_visible = v; });
  for (const int map : {4, 8, 16})
    for (const int rank : {3, 6, 12}) {
      if (quick && map == 8) continue;
      add("rank and map", "surface_map = " + std::to_string(map) + ", max_rank = " + std::to_string(rank),
          [&](Options& o) {
            o.surface_map = map;
            set_rank(o, rank);
          });
    }
  return settings;
}

std::vector<Setting> part_settings(const SurfaceLightFieldOptions& base) {
  std::vector<Setting> settings{{"as built in", "as built in", base}};
  const auto add = [&](const char* part, const char* name, const auto& set) {
    settings.push_back({name, part, base});
    set(settings.back().options);
  };
  using Options = SurfaceLightFieldOptions;
  const auto delaunay = [](Options& o) { o.patch.interpolation.method = ViewMethod::kDelaunay; };
  const auto least_squares = [](Options& o) { o.patch.factor.imputation = Imputation::kLeastSquares; };
  const auto plain_kriging = [](Options& o) {
    o.patch.interpolation.drift = o.patch.interpolation.exponential = false;
  };
  add("between views", "the paper's Delaunay", delaunay);
  add("hidden rows", "the paper's least squares, gated", least_squares);
  add("both", "the paper's for both", [&](Options& o) {
    delaunay(o);
    least_squares(o);
  });
  add("between views", "Matern kernels, no shared reflection", plain_kriging);
  add("between views", "no shared reflection", [](Options& o) { o.patch.interpolation.drift = false; });
  add("between views", "Matern kernels alone", [](Options& o) { o.patch.interpolation.exponential = false; });
  add("hidden rows", "half of a patch visible", [](Options& o) { o.patch.min_visible = 0.5; });
  add("hidden rows", "whole patches alone", [](Options& o) { o.patch.min_visible = 1; });
  add("sampling", "linear", [](Options& o) { o.sampling = Sampling::kLinear; });
  add("sampling", "a pixel away from edges", [](Options& o) { o.visibility.erosion_px = 1; });
  add("factorization", "no terms beyond those displayed",
      [](Options& o) { o.patch.factor.internal_rank = o.patch.factor.max_rank; });
  return settings;
}

std::vector<Setting> effort_level_settings(const SurfaceLightFieldOptions& base) {
  std::vector<Setting> settings;
  for (int level = 1; level < base.effort_levels(); ++level)
    settings.push_back({"effort level " + std::to_string(level), "effort level", at_effort_level(base, level)});
  return settings;
}

TradeoffPoint measure_setting(const Experiment& experiment, const Setting& setting) {
  const OnlineRun run = build_online(experiment.mesh, experiment.in_order(), setting.options);
  const Scores scores = score(experiment.held_out, *fill_unseen(*run.model), *experiment.painter);
  return {.setting = setting,
          .image_ms = run.median_ms(),
          .cpu_ms = 1e3 * run.cpu_s / static_cast<double>(run.image_ms.size()),
          .bytes = static_cast<double>(run.bytes),
          .mean_rank = run.mean_rank,
          .psnr_db = scores.psnr_db,
          .ssim = scores.ssim};
}

std::vector<std::size_t> pareto_frontier(std::span<const double> cost, std::span<const double> worth) {
  std::vector<std::size_t> order(cost.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t i) { return !std::isfinite(cost[i]) || !std::isfinite(worth[i]); });
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::make_pair(cost[a], -worth[a]) < std::make_pair(cost[b], -worth[b]);
  });
  std::vector<std::size_t> frontier;
  for (const std::size_t i : order)
    if (frontier.empty() || worth[i] > worth[frontier.back()]) frontier.push_back(i);
  return frontier;
}

TradeoffChoice choose_setting(std::span<const TradeoffPoint> points, const Limits& limits) {
  // What a choice is judged by, in the order of what matters; the least one is taken.
  using Judgement = std::tuple<double, double, double, double>;
  const auto judge = [&](const TradeoffPoint& p) -> Judgement {
    const double over = excess(p, limits);
    const double short_db = limits.psnr_db ? std::max(0.0, *limits.psnr_db - p.psnr_db) : -p.psnr_db;
    return {over, short_db, p.image_ms, p.bytes};
  };
  TradeoffChoice choice;
  for (std::size_t i = 1; i < points.size(); ++i)
    if (judge(points[i]) < judge(points[choice.index])) choice.index = i;
  const TradeoffPoint& chosen = points[choice.index];
  choice.holds = excess(chosen, limits) == 1 && (!limits.psnr_db || chosen.psnr_db >= *limits.psnr_db);
  return choice;
}

}  // namespace sheen
