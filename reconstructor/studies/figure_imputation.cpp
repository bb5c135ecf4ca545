// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "common/base/format.h"
#include "common/image/color.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/studies/figure.h"

namespace sheen {
namespace {

/// The picture with what no image gave a value in red, as the paper's figure has it.
ImageU8 with_holes_red(const PaintedView& view) {
  ImageU8 picture = to_srgb8(view.beauty);
  for (std::size_t i = 0; i < view.coverage.size(); ++i)
    if (view.coverage.data()[i] == kCoverageUnseen) {
      picture.data()[3 * i] = 220;
      picture.data()[3 * i + 1] = picture.data()[3 * i + 2] = 0;
    }
  return picture;
}

/// Fraction of the views' object pixels that the model has no value for.
double share_missing(const Experiment& experiment, const Appearance& model) {
  double missing = 0, all = 0;
  for (const HeldOutView& view : experiment.held_out) {
    const PaintedView painted = experiment.painter->paint(model, view.camera, view.camera_from_object);
    const ImageU8 object = view.pixels().object;
    for (std::size_t i = 0; i < object.size(); ++i) {
      if (object.data()[i] == 0) continue;
      ++all;
      missing += painted.coverage.data()[i] == kCoverageUnseen;
    }
  }
  return all > 0 ? missing / all : 0;
}

}  // namespace

Figure figure_imputation(const Experiment& experiment, const FigureOptions& options) {
  struct Way {
    const char *name, *file;
    double min_visible;
    Imputation imputation;
  };
  constexpr std::array<Way, 3> kWays{{{"patches with a hole are left out", "off", 1, Imputation::kMostProbable},
                                      {"as in the paper", "paper", 0.5, Imputation::kLeastSquares},
                                      {"as Sheen does", "on", 0.1, Imputation::kMostProbable}}};
  Figure figure{.number = 5, .title = "Missing values"};
  figure.paper = "Without imputation large parts of the bust have no data (282 pictures); with it they are filled in.";
  std::array<double, kWays.size()> missing{}, psnr{};
  for (std::size_t i = 0; i < kWays.size(); ++i) {
    SurfaceLightFieldOptions model = options.model;
    model.patch.min_visible = kWays[i].min_visible;
    model.patch.factor.imputation = kWays[i].imputation;
    const OnlineRun run = build_online(experiment.mesh, experiment.in_order(), model);
    missing[i] = share_missing(experiment, *run.model);
    psnr[i] = mean_psnr_db(experiment.held_out, *fill_unseen(*run.model), *experiment.painter);
    const HeldOutView& view = experiment.held_out[experiment.held_out.size() / 2];
    figure.pictures.push_back(
        {std::string("figure_05_imputation_") + kWays[i].file,
         format("%s: %.1f %% of the object without a value (red)", kWays[i].name, 100 * missing[i]),
         with_holes_red(experiment.painter->paint(*run.model, view.camera, view.camera_from_object))});
  }
  figure.ours = format(
      "Object pixels of held-out views without a value: %.1f %% when patches with a hole are left out, %.1f %% with "
      "the "
      "paper's least squares and gates, %.1f %% as Sheen imputes. Held-out PSNR, holes guessed from their neighbours: "
      "%.2f, "
      "%.2f and %.2f dB.",
      100 * missing[0], 100 * missing[1], 100 * missing[2], psnr[0], psnr[1], psnr[2]);
  figure.holds = missing[2] < missing[0] && psnr[2] > psnr[0];
  Plot plot{.title = "Imputation (figure 5)",
            .x = {.label = "columns used", .categories = {"whole patches", "the paper", "Sheen"}},
            .y = {.label = "object pixels without a value (%)"}};
  plot.series.push_back({.name = "no value", .style = PlotStyle::kBars});
  for (std::size_t i = 0; i < kWays.size(); ++i) plot.series[0].add(static_cast<double>(i), 100 * missing[i]);
  figure.plots.push_back({"figure_05_imputation", std::move(plot)});
  return figure;
}

}  // namespace sheen
