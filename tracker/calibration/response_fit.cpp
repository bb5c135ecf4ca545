// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/response_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/base/errors.h"
#include "common/base/format.h"

namespace sheen {
namespace {

constexpr double kLevel = 1 / 255.0;
constexpr double kFlat = 0.03;     ///< standard deviation in a cell, of full scale; above it the scene has detail
constexpr double kClipSigmas = 4;  ///< a cell whose pixels reach the ends of the scale is not used
constexpr double kNearSaturation = 0.005;
constexpr int kFewestSaturated = 5;  ///< cells
constexpr int kFewestTracks = 30;
constexpr std::array kFormulas{ResponseModel::kLinear, ResponseModel::kSrgb, ResponseModel::kGamma};
constexpr int kIterations = 20, kExposureIterations = 6;
constexpr double kConverged = 1e-6;  ///< greatest step
constexpr int kLightIterations = 3;
constexpr double kSmallestSlope = 1e-3;
constexpr double kLeastNoise = 0.05;      ///< what a perfect fit may say of the variances of the pixels
constexpr double kModelVariance = 1e-12;  ///< no mean is surer than this
constexpr double kOutlier = 25;           ///< times the median of the mean squared residuals of cells
constexpr double kLongestStep = 0.2;      ///< of any number, light or exposure
constexpr double kLargestExposureSigma = 0.05;
constexpr double kSmallestExposureSigma = 1e-5, kFirstExposureSigma = 3e-3, kLeastKnown = 0.5;
constexpr double kCurvePrior = 0.5;    ///< standard deviation of a correction where no cell says anything, light
constexpr double kHardlyWorse = 0.02;  ///< levels
constexpr double kDarkFloor = 0.01, kDarkClipped = 0.3;  ///< uncertainty of dark frames, levels
constexpr double kBendDoubt = 0.25;

struct Row {
  int image = 0;
  double value = 0, pixel_variance = 0, variance = 0;  ///< of the mean
};
/// A cell of a channel: what it showed at several exposures of one amount of light.
using Track = std::vector<Row>;

struct Dark {
  double value = 0, sigma = 0, pixel_variance = 0;
};

struct Problem {
  std::vector<Track> tracks;
  std::vector<double> exposures;
  std::optional<Dark> dark;
};

/// A finished estimate of one model.
struct Estimate {
  Response response;
  Eigen::MatrixXd covariance;
  std::vector<double> exposure_error;
  double exposure_sigma = kFirstExposureSigma;
  double noise_factor = 1;
};

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

std::vector<Track> tracks_of(std::span<const CellImage> sweep, double saturation) {
  std::vector<Track> tracks;
  for (std::size_t cell = 0; cell < sweep[0].values.size(); ++cell) {
    Track track;
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

/// A row under a response: what is left of its value, and how the predicted value follows from the scene's light. All
/// at the predicted value, for what is taken at the observed one has its noise in it.
struct Predicted {
  double residual = 0;  ///< of the value
  double value = 0;     ///< of a single pixel without noise
  double by_light = 0;  ///< derivative of the value by the light on the sensor
  double weight = 0;
};

Predicted predict(const Response& response, const Row& row, double light) {
  Predicted p;
  p.value = response.value(light, row.value);
  const LightOfValue g = response(p.value);
  p.by_light = 1 / std::max(g.slope, kSmallestSlope);
  // The mean of the pixels' values is not the value of their mean light.
  const double mean = p.value - 0.5 * g.bend * p.by_light * row.pixel_variance;
  p.residual = row.value - mean;
  p.weight = 1 / (row.variance + kModelVariance);
  return p;
}

double exposure_of(const Problem& problem, std::span<const double> error, int image) {
  return problem.exposures[image] * (1 + error[image]);
}

/// The light of a cell that fits its rows best, and the rows under it.
double scene_light(const Track& track, const Problem& problem, const Response& response,
                   std::span<const double> exposure_error, std::vector<Predicted>& rows) {
  rows.resize(track.size());
  const Row& brightest = *std::max_element(track.begin(), track.end(),
                                           [](const Row& one, const Row& other) { return one.value < other.value; });
  double light = response(brightest.value).light / exposure_of(problem, exposure_error, brightest.image);
  for (int i = 0; i < kLightIterations; ++i) {
    double sum = 0, weight = 0;
    for (std::size_t k = 0; k < track.size(); ++k) {
      const double t = exposure_of(problem, exposure_error, track[k].image);
      rows[k] = predict(response, track[k], light * t);
      const double derivative = rows[k].by_light * t;
      sum += rows[k].weight * derivative * rows[k].residual;
      weight += rows[k].weight * derivative * derivative;
    }
    light += sum / weight;
  }
  return light;
}

/// Sum of squared residuals over their variances, and what its derivatives say: the light of each cell is eliminated.
struct Normal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double chi2 = 0;
  double freedom = 0;
};

Normal normal_equations(const Problem& problem, const Estimate& now) {
  const int n = now.response.unknowns(), images = static_cast<int>(problem.exposures.size());
  Normal normal{Eigen::MatrixXd::Zero(n + images, n + images), Eigen::VectorXd::Zero(n + images)};
  std::vector<Predicted> rows;
  for (const Track& track : problem.tracks) {
    const double light = scene_light(track, problem, now.response, now.exposure_error, rows);
    Eigen::VectorXd shared = Eigen::VectorXd::Zero(n + images);
    double own = 0;
    for (std::size_t k = 0; k < track.size(); ++k) {
      const int j = track[k].image;
      const double t = exposure_of(problem, now.exposure_error, j), w = rows[k].weight;
      const double by_scene = rows[k].by_light * t, by_exposure = rows[k].by_light * light * problem.exposures[j];
      const Eigen::VectorXd by_response = -rows[k].by_light * now.response.gradient(rows[k].value);
      normal.matrix.topLeftCorner(n, n) += w * by_response * by_response.transpose();
      normal.matrix.block(0, n + j, n, 1) += w * by_exposure * by_response;
      normal.matrix(n + j, n + j) += w * by_exposure * by_exposure;
      normal.right.head(n) += w * rows[k].residual * by_response;
      normal.right[n + j] += w * rows[k].residual * by_exposure;
      shared.head(n) += w * by_scene * by_response;
      shared[n + j] += w * by_scene * by_exposure;
      own += w * by_scene * by_scene;
      normal.chi2 += w * rows[k].residual * rows[k].residual;
    }
    normal.matrix -= shared * shared.transpose() / own;
    normal.freedom += double(track.size()) - 1;
  }
  normal.matrix.bottomLeftCorner(images, n) = normal.matrix.topRightCorner(n, images).transpose();
  normal.freedom = std::max(1.0, normal.freedom - n);
  return normal;
}

/// The value without light and without noise: the mean of dark frames is lower where the response is bent over their
/// noise. What of that is more than the second order is not known.
Dark without_bend(Dark dark, const Response& response) {
  const LightOfValue g = response(response.value(0, dark.value));
  const double shift = 0.5 * g.bend / std::max(g.slope, kSmallestSlope) * dark.pixel_variance;
  dark.value += shift;
  dark.sigma = std::hypot(dark.sigma, kBendDoubt * shift);
  return dark;
}

void add_priors(const Problem& problem, const Estimate& now, Normal& normal) {
  const int n = now.response.unknowns();
  if (problem.dark) {
    const Dark dark = without_bend(*problem.dark, now.response);
    const LightOfValue g = now.response(dark.value);
    const Eigen::VectorXd gradient = now.response.gradient(dark.value);
    const double w = 1 / std::pow(std::max(g.slope, kSmallestSlope) * dark.sigma, 2);
    normal.matrix.topLeftCorner(n, n) += w * gradient * gradient.transpose();
    normal.right.head(n) -= w * g.light * gradient;
  }
  if (now.response.model() == ResponseModel::kCurve)
    normal.matrix.topLeftCorner(n, n).diagonal().array() += 1 / (kCurvePrior * kCurvePrior);
  for (std::size_t j = 0; j < problem.exposures.size(); ++j) {
    const double w = 1 / (now.exposure_sigma * now.exposure_sigma);
    const auto at = static_cast<Eigen::Index>(std::size_t(n) + j);
    normal.matrix(at, at) += w;
    normal.right[at] -= w * now.exposure_error[j];
  }
}

/// One step of Gauss and Newton; returns the greatest change of the response's numbers.
double improve(const Problem& problem, Estimate& now, Eigen::VectorXd& exposure_variance) {
  const int n = now.response.unknowns();
  Normal normal = normal_equations(problem, now);
  now.noise_factor = std::sqrt(std::max(normal.chi2 / normal.freedom, kLeastNoise));
  const double noise2 = now.noise_factor * now.noise_factor;
  normal.matrix /= noise2;
  normal.right /= noise2;
  add_priors(problem, now, normal);
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal.matrix);
  Eigen::VectorXd step = solver.solve(normal.right);
  if (!step.allFinite()) throw Error("the response cannot be estimated from this sweep");
  const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(step.size(), step.size()));
  step *= std::min(1.0, kLongestStep / step.cwiseAbs().maxCoeff());
  now.response.move(step.head(n));
  for (std::size_t j = 0; j < now.exposure_error.size(); ++j)
    now.exposure_error[j] += step[static_cast<Eigen::Index>(std::size_t(n) + j)];
  now.covariance = covariance.topLeftCorner(n, n);
  exposure_variance = covariance.diagonal().tail(step.size() - n);
  return step.head(n).cwiseAbs().maxCoeff();
}

/// First as if exposures were exact: free from the beginning they would take up what a wrong response leaves. Then
/// their errors are as large as the images themselves say (MacKay 1992): their squares over the number of them that
/// the images determine.
Estimate estimate(const Problem& problem, const Response& start) {
  Estimate now{.response = start, .exposure_sigma = kSmallestExposureSigma};
  now.exposure_error.assign(problem.exposures.size(), 0);
  Eigen::VectorXd variance;
  for (int i = 0; i < kIterations && improve(problem, now, variance) > kConverged;) ++i;
  now.exposure_sigma = kFirstExposureSigma;
  for (int i = 0; i < kExposureIterations; ++i) {
    improve(problem, now, variance);
    const Eigen::Map<const Eigen::VectorXd> errors(now.exposure_error.data(), variance.size());
    const double known = (1 - variance.array() / (now.exposure_sigma * now.exposure_sigma)).max(0).sum();
    now.exposure_sigma = std::clamp(std::sqrt(errors.squaredNorm() / std::max(known, kLeastKnown)),
                                    kSmallestExposureSigma, kLargestExposureSigma);
  }
  return now;
}

/// Mean squared residual of each track, in levels.
std::vector<double> track_errors(const std::vector<Track>& tracks, const Problem& problem, const Estimate& fit,
                                 bool weighted) {
  std::vector<double> errors;
  std::vector<Predicted> rows;
  for (const Track& track : tracks) {
    scene_light(track, problem, fit.response, fit.exposure_error, rows);
    double sum = 0;
    for (const Predicted& row : rows)
      sum += weighted ? row.weight * row.residual * row.residual : std::pow(row.residual / kLevel, 2);
    errors.push_back(sum / double(track.size() - 1));
  }
  return errors;
}

double mean_of(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

/// Drops the cells that do not follow the others: something moved there, or a reflection came and went.
int reject_outliers(Problem& problem, const Estimate& fit) {
  const std::vector<double> errors = track_errors(problem.tracks, problem, fit, true);
  std::vector<double> sorted = errors;
  std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
  const double most = kOutlier * sorted[sorted.size() / 2];
  std::vector<Track> kept;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (errors[i] <= most) kept.push_back(problem.tracks[i]);
  const auto rejected = static_cast<int>(problem.tracks.size() - kept.size());
  problem.tracks = std::move(kept);
  return rejected;
}

struct Compared {
  ResponseComparison comparison;
  Estimate estimate;
  std::vector<double> errors;  ///< of each track, estimated from the others
};

Compared compare(const Problem& problem, const Response& start) {
  Compared result{.estimate = estimate(problem, start)};
  result.comparison = {.model = start.model(),
                       .unknowns = start.unknowns(),
                       .rms_levels = std::sqrt(mean_of(track_errors(problem.tracks, problem, result.estimate, false)))};
  result.errors.resize(problem.tracks.size());
  for (const std::size_t part : {0u, 1u}) {
    Problem half = problem;
    half.tracks.clear();
    std::vector<Track> others;
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

std::optional<Dark> dark_value(std::span<const CellImage> dark) {
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
  return Dark{mean, std::hypot(sigma, kLevel * (cut_off ? kDarkClipped : kDarkFloor)), variance};
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
  Problem problem{.tracks = tracks_of(sweep, fit.saturation), .dark = dark_value(dark)};
  double mean_exposure = mean_of(exposures);
  for (const double exposure : exposures) problem.exposures.push_back(exposure / mean_exposure);
  if (problem.tracks.size() < kFewestTracks)
    throw Error(
        format("only %zu of the image's cells are neither dark nor clipped nor full of detail in two of the "
               "images; give images of a scene with smooth surfaces at more exposures",
               problem.tracks.size()));
  fit.lowest = 1;
  fit.highest = 0;
  for (const Track& track : problem.tracks)
    for (const Row& row : track) {
      fit.lowest = std::min(fit.lowest, row.value);
      fit.highest = std::max(fit.highest, row.value);
    }

  // A first look at who does not follow: by a curve, which is wrong about nobody.
  std::vector<Estimate> formulas;
  for (const ResponseModel model : kFormulas) formulas.push_back(estimate(problem, Response(model)));
  const Estimate& nearest =
      *std::min_element(formulas.begin(), formulas.end(),
                        [](const Estimate& a, const Estimate& b) { return a.noise_factor < b.noise_factor; });
  const Response flexible = Response::curve_over(nearest.response, fit.lowest, fit.highest);
  fit.cells_rejected = reject_outliers(problem, estimate(problem, flexible));

  std::vector<Compared> all;
  for (const Estimate& formula : formulas) all.push_back(compare(problem, formula.response));
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
    const Dark dark_frames = without_bend(*problem.dark, fit.response);
    fit.dark_value = dark_frames.value;
    fit.dark_uncertainty = dark_frames.sigma;
    problem.dark.reset();
    const Response start = chosen.estimate.response;
    const Estimate alone = estimate(problem, start);
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
