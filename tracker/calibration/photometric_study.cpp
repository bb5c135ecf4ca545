// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/photometric_study.h"

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/format.h"

namespace sheen {
namespace {

constexpr double kClipSigmas = 4, kDarkest = 0.02, kFlat = 0.03, kNearSaturation = 0.005;
constexpr int kFewestCells = 4;
constexpr double kBalanceFloor = 1e-4;   ///< nobody's grey is more grey
constexpr double kExposureDoubt = 0.01;  ///< relative
constexpr double kDifferenceSigmas = 4, kSameLevels = 0.5;
constexpr double kNoiseDoubt = 5;
constexpr double kRingDoubt = 0.01, kColourDoubt = 0.02;
constexpr double kLowestWanted = 0.1, kHighestWanted = 0.9;

bool inside(const Patch& patch, const CellImage& image, int column, int row) {
  if (patch.empty()) return true;
  const int x = column * image.cell_px, y = row * image.cell_px;
  return x >= patch.x && y >= patch.y && x + image.cell_px <= patch.x + patch.width &&
         y + image.cell_px <= patch.y + patch.height;
}

bool usable(const CellValue& cell, double saturation) {
  const double sigma = std::sqrt(cell.variance);
  return cell.mean > kDarkest && cell.mean - kClipSigmas * sigma > 0 && sigma < kFlat &&
         cell.mean + kClipSigmas * sigma < saturation * (1 - kNearSaturation);
}

}  // namespace

BalanceFit fit_balance(std::span<const CellImage> greys, const Patch& patch, const ResponseFit& response,
                       const VignetteFit* vignette) {
  std::array<std::vector<double>, 3> ratios;  // logarithms, to green
  for (const CellImage& image : greys) {
    if (image.channels != 3) throw Error(image.name + " has no colours; a white balance needs them (--mosaic?)");
    for (int row = 0; row < image.rows; ++row)
      for (int column = 0; column < image.columns; ++column) {
        if (!inside(patch, image, column, row)) continue;
        std::array<double, 3> light{};
        bool all = true;
        for (int c = 0; c < 3; ++c) {
          const CellValue& cell = image.at(column, row, c);
          const LightOfValue g = response.response(cell.mean);
          light[c] = g.light + 0.5 * g.bend * cell.variance;
          all &= usable(cell, response.saturation) && light[c] > 0;
        }
        if (vignette)  // the same for all colours: what is left of it is a doubt about the edge, not about the balance
          all &= vignette->vignette.at(image.x(column), image.y(row), image.size) > 0.2;
        if (!all) continue;
        for (int c = 0; c < 3; ++c) ratios[c].push_back(std::log(light[1] / light[c]));
      }
  }
  BalanceFit fit;
  fit.cells = static_cast<int>(ratios[1].size());
  if (fit.cells < kFewestCells)
    throw Error("the grey target shows in " + std::to_string(fit.cells) +
                " usable cells only: give --patch where it is, and an exposure that clips no colour");
  for (int c = 0; c < 3; ++c) {
    double sum = 0, squares = 0;
    for (const double ratio : ratios[c]) sum += ratio;
    const double mean = sum / fit.cells;
    for (const double ratio : ratios[c]) squares += (ratio - mean) * (ratio - mean);
    fit.gains[c] = std::exp(mean);
    fit.uncertainty[c] = c == 1 ? 0 : std::hypot(kBalanceFloor, std::sqrt(squares / (fit.cells - 1) / fit.cells));
  }
  return fit;
}

PhotometricCalibration calibration_of(const PhotometricStudy& study) {
  const ResponseFit& fit = study.response;
  PhotometricCalibration result;
  result.response = to_string(fit.response.model());
  result.gamma = fit.response.gamma();
  result.black_level = fit.black_level();
  result.black_level_uncertainty = fit.black_level_uncertainty();
  result.reference_value = fit.highest;
  const double white = fit.response(1).light, reference = fit.response(fit.highest).light / white;
  Photometry& photometry = result.photometry;
  float before = 0;
  for (int i = 0; i < 256; ++i) {
    const auto light = static_cast<float>(std::clamp(fit.response(i / 255.0).light / white, 0.0, 1.0));
    photometry.response[i] = before = std::max(before, light);
    result.response_uncertainty[i] = static_cast<float>(reference * fit.relative_uncertainty(i / 255.0));
  }
  photometry.response[255] = 1;
  photometry.saturation = static_cast<float>(fit.saturation);
  photometry.vignette.cx = (study.size.width - 1) / 2.0;
  photometry.vignette.cy = (study.size.height - 1) / 2.0;
  if (study.vignette && study.vignette->determined()) {
    photometry.vignette = study.vignette->vignette;
    result.vignette = {study.vignette->worst_uncertainty, study.vignette->centre_uncertainty_px};
  }
  if (study.balance) {
    for (int c = 0; c < 3; ++c) photometry.white_balance[c] = static_cast<float>(study.balance->gains[c]);
    result.white_balance = study.balance->uncertainty;
  }
  return result;
}

std::vector<std::string> warnings(const PhotometricStudy& study) {
  const ResponseFit& fit = study.response;
  std::vector<std::string> all;
  if (fit.lowest > kLowestWanted || fit.highest < kHighestWanted * fit.saturation)
    all.push_back(
        format("the sweep shows values from %.0f to %.0f of 255 only; what lies beyond is extrapolated: add "
               "exposures",
               255 * fit.lowest, 255 * fit.highest));
  for (std::size_t j = 0; j < fit.exposure_error.size(); ++j)
    if (std::abs(fit.exposure_error[j]) > kExposureDoubt)
      all.push_back(format("%s got %+.1f %% of the light that its exposure says: is the lamp steady, the time exact?",
                           study.names[j].c_str(), 100 * fit.exposure_error[j]));
  const double difference = std::abs(fit.dark_value - fit.intercept);
  if (fit.has_dark && difference > kSameLevels / 255 &&
      difference > kDifferenceSigmas * std::hypot(fit.dark_uncertainty, fit.intercept_uncertainty))
    all.push_back(
        format("the dark frames are at %.2f of 255, the sweep says %.2f +- %.2f without light: does light get "
               "in, or are the exposures wrong?",
               255 * fit.dark_value, 255 * fit.intercept, 255 * fit.intercept_uncertainty));
  if (fit.noise_factor > kNoiseDoubt)
    all.push_back(
        format("cells differ from the response by %.1f times what the pixels' noise explains: did something "
               "move, or is there stray light?",
               fit.noise_factor));
  if (!study.vignette) {
    all.push_back("the vignette was not measured: give --flat");
  } else if (!study.vignette->determined()) {
    all.push_back(format(
        "light and lens cannot be told apart (the vignette is uncertain by %.0f %%): no vignette is written. Give flat "
        "images with the target shifted in the image and --moves, or --evenly-lit where the light is known to be even",
        100 * study.vignette->worst_uncertainty));
  } else {
    if (study.vignette->left_radial > kRingDoubt)
      all.push_back(
          format("up to %.1f %% of the light follows no radial polynomial: is the target flat and white all "
                 "over, the light smooth?",
                 100 * study.vignette->left_radial));
    if (study.vignette->left_colour > kColourDoubt)
      all.push_back(format("the colours are shaded differently, by up to %.1f %%; one vignette is used for all",
                           100 * study.vignette->left_colour));
  }
  return all;
}

}  // namespace sheen
