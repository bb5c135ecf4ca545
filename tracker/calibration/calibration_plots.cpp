// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/calibration_plots.h"

#include "common/base/files.h"
#include "common/plot/heat_map.h"

namespace sheen {
namespace {

/// Half a pixel spoils a capture; what is beyond shows as that.
constexpr double kMostShown_px = 0.5;

HeatMap drawn(const ImageMap& map, const std::string& title, const std::string& value) {
  return {.title = title,
          .value = value,
          .width = map.width,
          .height = map.height,
          .columns = map.columns,
          .rows = map.rows,
          .values = map.values,
          .most = map.worst() > kMostShown_px ? kMostShown_px : 0};
}

Plot residuals_of_images(const Calibration& calibration) {
  Plot plot{.title = "Reprojection error of each image", .x = {.label = "image"}, .y = {.label = "RMS (px)"}};
  PlotSeries used{.name = "corners used", .style = PlotStyle::kBars};
  for (const CalibratedView& view : calibration.views) {
    if (!view.used) continue;
    used.add(double(plot.x.categories.size()), view.rms_px);
    plot.x.categories.push_back(view.name.substr(0, view.name.rfind('.')));
  }
  plot.x.upright_categories = true;
  plot.series = {used};
  plot.levels = {{"all images", calibration.rms_px}};
  return plot;
}

}  // namespace

PlotFiles write_calibration_plots(const CalibrationStudy& study, const std::filesystem::path& folder) {
  make_folder(folder);
  HeatMap uncertainty = drawn(study.uncertainty, "Uncertainty of a pixel, and where corners were seen", "pixels (RMS)");
  for (const TargetView& view : study.calibration.used)
    for (const TargetSighting& s : view.sightings) uncertainty.points.push_back({s.pixel.x(), s.pixel.y()});
  if (study.halves)
    write_heat_map(drawn(study.halves->difference, "Difference of the cameras of two halves of the images", "pixels"),
                   folder / "halves");
  write_plot(residuals_of_images(study.calibration), folder / "images");
  return write_heat_map(uncertainty, folder / "uncertainty");
}

}  // namespace sheen
