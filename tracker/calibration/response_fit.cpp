// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/response_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/order_statistics.h"
#include "tracker/calibration/sweep_estimate.h"

namespace sheen {
namespace {

constexpr double kLevel = 1 / 255.0;
constexpr double kFlat = 0.03;     ///< standard deviation in a cell, of full scale; above it the scene has detail
constexpr double kClipSigmas = 4;  ///< a cell whose pixels reach the ends of the scale is not used
constexpr double kNearSaturation = 0.005;
constexpr int kFewestSaturated = 5;  ///< cells
constexpr int kFewestTracks = 30;
constexpr std::array kFormulas{ResponseModel::kLinear, ResponseModel::kSrgb, ResponseModel::kGamma};
constexpr double kOutlier = 25;                          ///< times the median of the mean squared residuals of cells
constexpr double kHardlyWorse = 0.02;                    ///< levels
constexpr double kDarkFloor = 0.01, kDarkClipped = 0.3;  ///< uncertainty of dark frames, levels

void find_saturation(std::span<const CellImage> sweep, ResponseFit& fit) {
  double highest = 0;
  for (const CellImage& image : sweep)
    for (const CellValue& cell : image.values) highest = std::max(highest, double(cell.mean));
  int saturated = 0;
  for (const CellImage& image : sweep)
    for (const CellValue& cell : image.values)
      saturated += cell.mean > (1 - kNearSaturation) * highest && cell.variance < 0.25 * kLevel * kLevel;
  fit.saturation_seen = saturated >= kFewestSaturated;
  if (fit.saturation_seen) fit.saturation = highest;
}

std::vector<SweepTrack> tracks_of(std::span<const CellImage> sweep, double saturation) {
  std::vector<SweepTrack> tracks;
  for (std::size_t cell = 0; cell < sweep[0].values.size(); ++cell) {
    SweepTrack track;
    for (std::size_t j = 0; j < sweep.size(); ++j) {
      const CellValue& value = sweep[j].values[cell];
      const double sigma = std::sqrt(value.variance);
      const bool clipped = value.mean - kClipSigmas * sigma < 0.5 / sweep[j].levels ||
                           value.mean + kClipSigmas * sigma > saturation * (1 - kNearSaturation);
      if (clipped || sigma > kFlat) continue;
      track.push_back({static_cast<int>(j), value.mean, value.variance, value.mean_variance(sweep[j].levels)});
    }
    if (track.size() >= 2) tracks.push_back(std::move(track));
  }
  return tracks;
}

double mean_of(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

/// Drops the cells that do not follow the others: something moved there, or a reflection came and went.
int reject_outliers(SweepProblem& problem, const SweepEstimate& fit) {
  const std::vector<double> errors = track_errors(problem.tracks, problem, fit, true);
  std::vector<double> sorted = errors;
  const double most = kOutlier * median(sorted);
  std::vector<SweepTrack> kept;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (errors[i] <= most) kept.push_back(problem.tracks[i]);
  const auto rejected = static_cast<int>(problem.tracks.size() - kept.size());
  problem.tracks = std::move(kept);
  return rejected;
}

struct Compared {
  ResponseComparison comparison;
  SweepEstimate estimate;
  std::vector<double> errors;  ///< of each track, estimated from the others
};

Compared compare(const SweepProblem& problem, const Response& start) {
  Compared result{.estimate = estimate(problem, start)};
  result.comparison = {.model = start.model(),
                       .unknowns = start.unknowns(),
                       .rms_levels = std::sqrt(mean_of(track_errors(problem.tracks, problem, result.estimate, false)))};
  result.errors.resize(problem.tracks.size());
  for (const std::size_t part : {0u, 1u}) {
    SweepProblem half = problem;
    half.tracks.clear();
    std::vector<SweepTrack> others;
    for (std::size_t i = 0; i < problem.tracks.size(); ++i)
      (i % 2 == part ? others : half.tracks).push_back(problem.tracks[i]);
    const std::vector<double> errors = track_errors(others, half, estimate(half, result.estimate.response), false);
    for (std::size_t i = 0; i < errors.size(); ++i) result.errors[2 * i + part] = errors[i];
  }
  result.comparison.cross_validated_levels = std::sqrt(mean_of(result.errors));
  return result;
}

bool clearly_worse(const Compared& one, const Compared& best) {
  std::vector<double> difference(one.errors.size());
  for (std::size_t i = 0; i < difference.size(); ++i) difference[i] = one.errors[i] - best.errors[i];
  const double mean = mean_of(difference), count = static_cast<double>(difference.size());
  double spread = 0;
  for (const double d : difference) spread += (d - mean) * (d - mean);
  const bool significant = mean > 2 * std::sqrt(spread / (count - 1) / count);
  return significant && one.comparison.cross_validated_levels > best.comparison.cross_validated_levels + kHardlyWorse;
}

std::optional<DarkLevel> dark_value(std::span<const CellImage> dark) {
  std::vector<double> means, variances;
  for (const CellImage& image : dark)
    for (const CellValue& cell : image.values) {
      means.push_back(cell.mean);
      variances.push_back(cell.variance);
    }
  if (means.empty()) return std::nullopt;
  const double mean = mean_of(means), count = static_cast<double>(means.size());
  double spread = 0;
  for (const double value : means) spread += (value - mean) * (value - mean);
  const double sigma = std::sqrt(spread / std::max(1.0, count - 1) / count);
  const double variance = mean_of(variances);
  const bool cut_off = mean < std::max(0.5 * kLevel, 3 * std::sqrt(variance));  // at 0, nobody knows how much
  return DarkLevel{mean, std::hypot(sigma, kLevel * (cut_off ? kDarkClipped : kDarkFloor)), variance};
}

void check(std::span<const CellImage> sweep, std::span<const double> exposures) {
  if (sweep.size() < 3) throw Error("an exposure sweep needs at least 3 images");
  for (const CellImage& image : sweep)
    if (image.values.size() != sweep[0].values.size() || image.channels != sweep[0].channels)
      throw Error(image.name + " differs from " + sweep[0].name + " in size or channels; give one camera's images");
  const auto [least, most] = std::minmax_element(exposures.begin(), exposures.end());
  if (!(*least > 0))
    throw Error("the exposure of " + sweep[std::size_t(least - exposures.begin())].name +
                " is not known: neither EXIF nor --exposures says it");
  if (*most < 2 * *least) throw Error("the exposures differ by less than a factor of 2; give a wider sweep");
}

}  // namespace

double ResponseFit::relative_uncertainty(double value) const {
  const double at = response(value).light, top = response(highest).light;
  const Eigen::VectorXd gradient = (response.gradient(value) * top - response.gradient(highest) * at) / (top * top);
  return std::sqrt(std::max(0.0, gradient.dot(covariance * gradient)));
}

double ResponseFit::black_level_uncertainty() const {
  const double black = response.black_level();
  const Eigen::VectorXd gradient = response.gradient(black);
  return std::sqrt(std::max(0.0, gradient.dot(covariance * gradient))) / response(black).slope;
}

double ResponseFit::gamma_uncertainty() const {
  return response.model() == ResponseModel::kGamma ? std::sqrt(covariance(1, 1)) : 0;
}

double ResponseFit::nonlinearity() const {
  constexpr int kSteps = 100;
  Eigen::Matrix<double, kSteps + 1, 2> line;
  Eigen::Matrix<double, kSteps + 1, 1> light;
  for (int i = 0; i <= kSteps; ++i) {
    const double value = lowest + (highest - lowest) * i / kSteps;
    light[i] = value;
    line.row(i) << 1, response(value).light;
  }
  const Eigen::Vector2d fitted = (line.transpose() * line).ldlt().solve(line.transpose() * light);
  return (line * fitted - light).cwiseAbs().maxCoeff() / (highest - lowest);
}

ResponseFit fit_response(std::span<const CellImage> sweep, std::span<const double> exposures,
                         std::span<const CellImage> dark) {
  check(sweep, exposures);
  ResponseFit fit;
  find_saturation(sweep, fit);
  SweepProblem problem{.tracks = tracks_of(sweep, fit.saturation), .dark = dark_value(dark)};
  double mean_exposure = mean_of(exposures);
  for (const double exposure : exposures) problem.exposures.push_back(exposure / mean_exposure);
  if (problem.tracks.size() < kFewestTracks)
    throw Error(
        format("only %zu of the image's cells are neither dark nor clipped nor full of detail in two of the "
               "images; give images of a scene with smooth surfaces at more exposures",
               problem.tracks.size()));
  fit.lowest = 1;
  fit.highest = 0;
  for (const SweepTrack& track : problem.tracks)
    for (const SweepRow& row : track) {
      fit.lowest = std::min(fit.lowest, row.value);
      fit.highest = std::max(fit.highest, row.value);
    }

  // A first look at who does not follow: by a curve, which is wrong about nobody.
  std::vector<SweepEstimate> formulas;
  for (const ResponseModel model : kFormulas) formulas.push_back(estimate(problem, Response(model)));
  const SweepEstimate& nearest =
      *std::min_element(formulas.begin(), formulas.end(),
                        [](const SweepEstimate& a, const SweepEstimate& b) { return a.noise_factor < b.noise_factor; });
  const Response flexible = Response::curve_over(nearest.response, fit.lowest, fit.highest);
  fit.cells_rejected = reject_outliers(problem, estimate(problem, flexible));

  std::vector<Compared> all;
  for (const SweepEstimate& formula : formulas) all.push_back(compare(problem, formula.response));
  const auto by_error = [](const Compared& a, const Compared& b) {
    return a.comparison.cross_validated_levels < b.comparison.cross_validated_levels;
  };
  const Response base = std::min_element(all.begin(), all.end(), by_error)->estimate.response;
  all.push_back(compare(problem, Response::curve_over(base, fit.lowest, fit.highest)));
  const Compared& best = *std::min_element(all.begin(), all.end(), by_error);
  const Compared& chosen =
      *std::find_if(all.begin(), all.end(), [&](const Compared& c) { return !clearly_worse(c, best); });

  for (const Compared& one : all) fit.models.push_back(one.comparison);
  fit.response = chosen.estimate.response;
  fit.covariance = chosen.estimate.covariance;
  fit.exposure_error = chosen.estimate.exposure_error;
  fit.exposure_sigma = chosen.estimate.exposure_sigma;
  fit.noise_factor = chosen.estimate.noise_factor;
  fit.rms_levels = chosen.comparison.rms_levels;
  fit.cells_used = static_cast<int>(problem.tracks.size());
  if (problem.dark) {
    fit.has_dark = true;
    const DarkLevel dark_frames = without_bend(*problem.dark, fit.response);
    fit.dark_value = dark_frames.value;
    fit.dark_uncertainty = dark_frames.sigma;
    problem.dark.reset();
    const Response start = chosen.estimate.response;
    const SweepEstimate alone = estimate(problem, start);
    ResponseFit without;
    without.response = alone.response;
    without.covariance = alone.covariance;
    fit.intercept = without.black_level();
    fit.intercept_uncertainty = without.black_level_uncertainty();
  } else {
    fit.intercept = fit.black_level();
    fit.intercept_uncertainty = fit.black_level_uncertainty();
  }
  return fit;
}

}  // namespace sheen
