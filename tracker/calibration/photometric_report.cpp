// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/photometric_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/json_number.h"
#include "common/image/color.h"
#include "common/plot/heat_map.h"

namespace sheen {
namespace {

using nlohmann::json;

constexpr int kMapColumns = 32, kMapRows = 24;
constexpr int kPlotStep = 5;

void print_models(std::ostream& out, const ResponseFit& fit) {
  out << "response  numbers  RMS (levels of 255)  on cells left out\n";
  for (const ResponseComparison& model : fit.models)
    out << format("%-9s %7d %20.4f  %.4f%s\n", to_string(model.model), model.unknowns, model.rms_levels,
                  model.cross_validated_levels, model.model == fit.response.model() ? "  <- used" : "");
}

void print_vignette(std::ostream& out, const VignetteFit& fit) {
  const Vignette& v = fit.vignette;
  out << format("vignette: 1 %+.4f r^2 %+.4f r^4 %+.4f r^6 about (%.1f, %.1f) +- %.1f px, r in half diagonals\n",
                v.k[0], v.k[1], v.k[2], v.cx, v.cy, fit.centre_uncertainty_px);
  out << format(
      "  darkest corner %.3f of the middle, uncertain by %.2f %% at worst; RMS %.2f %% of %d cells (%d not used)\n",
      fit.corner, 100 * fit.worst_uncertainty, 100 * fit.rms, fit.cells_used, fit.cells_unused);
  out << format("  left in rings round the centre: %.2f %% at most; colours differ by %.2f %%\n", 100 * fit.left_radial,
                100 * fit.left_colour);
}

json response_json(const PhotometricStudy& study) {
  const ResponseFit& fit = study.response;
  json models = json::array();
  for (const ResponseComparison& model : fit.models)
    models.push_back({{"model", to_string(model.model)},
                      {"numbers", model.unknowns},
                      {"rms_levels", json_number(model.rms_levels)},
                      {"cross_validated_levels", json_number(model.cross_validated_levels)},
                      {"chosen", model.model == fit.response.model()}});
  json images = json::array();
  for (std::size_t i = 0; i < study.names.size(); ++i)
    images.push_back({{"file", study.names[i]}, {"exposure_error", json_number(fit.exposure_error[i])}});
  json response = {
      {"model", to_string(fit.response.model())},
      {"models", std::move(models)},
      {"images", std::move(images)},
      {"exposure_sigma", json_number(fit.exposure_sigma)},
      {"noise_factor", json_number(fit.noise_factor)},
      {"rms_levels", json_number(fit.rms_levels)},
      {"nonlinearity", json_number(fit.nonlinearity())},
      {"cells_used", fit.cells_used},
      {"cells_rejected", fit.cells_rejected},
      {"values", {json_number(fit.lowest), json_number(fit.highest)}},
      {"black_level",
       {{"value", json_number(fit.black_level())}, {"uncertainty", json_number(fit.black_level_uncertainty())}}},
      {"intercept", {{"value", json_number(fit.intercept)}, {"uncertainty", json_number(fit.intercept_uncertainty)}}},
      {"dark_frames", nullptr},
      {"gamma", nullptr},
      {"saturation", nullptr}};
  if (fit.has_dark)
    response["dark_frames"] = {{"value", json_number(fit.dark_value)},
                               {"uncertainty", json_number(fit.dark_uncertainty)}};
  if (fit.response.model() == ResponseModel::kGamma)
    response["gamma"] = {{"value", fit.response.gamma()}, {"uncertainty", json_number(fit.gamma_uncertainty())}};
  if (fit.saturation_seen) response["saturation"] = fit.saturation;
  return response;
}

Plot response_plot(const PhotometricStudy& study, const PhotometricCalibration& calibration) {
  Plot plot{.title = "Light of each stored value", .x = {.label = "value (of 255)"}, .y = {.label = "light"}};
  PlotSeries measured{.name = std::string("measured: ") + calibration.response, .style = PlotStyle::kLineAndMarkers};
  PlotSeries linear{.name = "proportional", .style = PlotStyle::kDashed},
      srgb{.name = "sRGB", .style = PlotStyle::kDashed};
  for (int value = 0; value < 256; value += kPlotStep) {
    measured.add(value, calibration.photometry.response[value]);
    measured.bars.push_back(calibration.response_uncertainty[value]);
    linear.add(value, value / 255.0);
    srgb.add(value, srgb_decode(float(value) / 255));
  }
  plot.series = {measured, linear, srgb};
  plot.title += format(" (seen from %.0f to %.0f)", 255 * study.response.lowest, 255 * study.response.highest);
  return plot;
}

Plot exposure_plot(const PhotometricStudy& study) {
  Plot plot{.title = "Light of each image beside what its exposure says",
            .x = {.label = "image"},
            .y = {.label = "difference (%)"}};
  PlotSeries errors{.name = "images", .style = PlotStyle::kMarkers};
  for (std::size_t i = 0; i < study.names.size(); ++i) {
    errors.add(double(i), 100 * study.response.exposure_error[i]);
    plot.x.categories.push_back(study.names[i].substr(0, study.names[i].rfind('.')));
  }
  plot.x.upright_categories = true;
  plot.series = {errors};
  plot.levels = {{"as it says", 0}};
  return plot;
}

HeatMap vignette_map(const VignetteFit& fit) {
  HeatMap map{.title = "Light that the lens lets through",
              .value = "of the light at the centre",
              .width = fit.size.width,
              .height = fit.size.height,
              .columns = kMapColumns,
              .rows = kMapRows};
  for (int row = 0; row < kMapRows; ++row)
    for (int column = 0; column < kMapColumns; ++column)
      map.values.push_back(fit.vignette.at(double(fit.size.width - 1) * column / (kMapColumns - 1),
                                           double(fit.size.height - 1) * row / (kMapRows - 1), fit.size));
  return map;
}

Plot rings_plot(const VignetteFit& fit) {
  Plot plot{.title = "What the vignette leaves, mean of rings",
            .x = {.label = "distance to the centre (half diagonals)"},
            .y = {.label = "light (%)"}};
  PlotSeries rings{.name = "rings"};
  for (std::size_t i = 0; i < fit.ring_radius.size(); ++i) rings.add(fit.ring_radius[i], 100 * fit.ring_residual[i]);
  plot.series = {rings};
  return plot;
}

}  // namespace

std::string photometric_text(const PhotometricStudy& study) {
  const ResponseFit& fit = study.response;
  std::ostringstream out;
  print_models(out, fit);
  out << format("%d cells used, %d rejected; values %.1f to %.1f of 255; residuals %.2f times the pixels' noise\n",
                fit.cells_used, fit.cells_rejected, 255 * fit.lowest, 255 * fit.highest, fit.noise_factor);
  out << format("black level %.3f +- %.3f of 255", 255 * fit.black_level(), 255 * fit.black_level_uncertainty());
  if (fit.has_dark)
    out << format(" (dark frames %.3f, the sweep alone %.3f +- %.3f)", 255 * fit.dark_value, 255 * fit.intercept,
                  255 * fit.intercept_uncertainty);
  out << '\n';
  if (fit.response.model() == ResponseModel::kGamma)
    out << format("gamma %.4f +- %.4f\n", fit.response.gamma(), fit.gamma_uncertainty());
  out << format("values depart from a straight line by %.2f %% of their range at most\n", 100 * fit.nonlinearity());
  if (fit.saturation_seen)
    out << format("saturation at %.1f of 255\n", 255 * fit.saturation);
  else
    out << "no image is saturated: the saturation level is taken to be full scale\n";
  out << format("exposures are kept to %.2f %%\n", 100 * fit.exposure_sigma);
  if (study.vignette) print_vignette(out, *study.vignette);
  if (study.balance)
    out << format("white balance: red %.4f +- %.4f, green 1, blue %.4f +- %.4f (%d cells)\n", study.balance->gains[0],
                  study.balance->gains[0] * study.balance->uncertainty[0], study.balance->gains[2],
                  study.balance->gains[2] * study.balance->uncertainty[2], study.balance->cells);
  for (const std::string& sentence : warnings(study)) out << "warning: " << sentence << '\n';
  return out.str();
}

std::string photometric_json(const PhotometricStudy& study) {
  json report = {{"response", response_json(study)},
                 {"vignette", nullptr},
                 {"white_balance", nullptr},
                 {"warnings", warnings(study)}};
  if (study.vignette) {
    const VignetteFit& fit = *study.vignette;
    json rings = json::array();
    for (std::size_t i = 0; i < fit.ring_radius.size(); ++i)
      rings.push_back({{"radius", fit.ring_radius[i]}, {"residual", json_number(fit.ring_residual[i])}});
    report["vignette"] = {{"k", fit.vignette.k},
                          {"centre", {fit.vignette.cx, fit.vignette.cy}},
                          {"centre_uncertainty_px", json_number(fit.centre_uncertainty_px)},
                          {"corner", json_number(fit.corner)},
                          {"uncertainty", json_number(fit.worst_uncertainty)},
                          {"determined", fit.determined()},
                          {"rms", json_number(fit.rms)},
                          {"left_radial", json_number(fit.left_radial)},
                          {"left_colour", json_number(fit.left_colour)},
                          {"cells_used", fit.cells_used},
                          {"cells_unused", fit.cells_unused},
                          {"rings", std::move(rings)}};
  }
  if (study.balance)
    report["white_balance"] = {
        {"gains", study.balance->gains}, {"uncertainty", study.balance->uncertainty}, {"cells", study.balance->cells}};
  return report.dump(2) + "\n";
}

PlotFiles write_photometric_plots(const PhotometricStudy& study, const std::filesystem::path& folder) {
  make_folder(folder);
  if (study.vignette) {
    write_heat_map(vignette_map(*study.vignette), folder / "vignette");
    write_plot(rings_plot(*study.vignette), folder / "vignette_rings");
  }
  write_plot(exposure_plot(study), folder / "exposures");
  return write_plot(response_plot(study, calibration_of(study)), folder / "response");
}

}  // namespace sheen
