// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/sweep_estimate.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <span>

#include "common/base/errors.h"

namespace sheen {
namespace {

constexpr double kLevel = 1 / 255.0;
constexpr int kIterations = 20, kExposureIterations = 6;
constexpr double kConverged = 1e-6;  ///< greatest step
constexpr int kLightIterations = 3;
constexpr double kSmallestSlope = 1e-3;
constexpr double kLeastNoise = 0.05;      ///< what a perfect fit may say of the variances of the pixels
constexpr double kModelVariance = 1e-12;  ///< no mean is surer than this
constexpr double kLongestStep = 0.2;      ///< of any number, light or exposure
constexpr double kLargestExposureSigma = 0.05;
constexpr double kSmallestExposureSigma = 1e-5, kFirstExposureSigma = 3e-3, kLeastKnown = 0.5;
constexpr double kCurvePrior = 0.5;  ///< standard deviation of a correction where no cell says anything, light
constexpr double kBendDoubt = 0.25;

/// A row under a response: what is left of its value, and how the predicted value follows from the scene's light. All
/// at the predicted value, for what is taken at the observed one has its noise in it.
struct Predicted {
  double residual = 0;  ///< of the value
  double value = 0;     ///< of a single pixel without noise
  double by_light = 0;  ///< derivative of the value by the light on the sensor
  double weight = 0;
};

Predicted predict(const Response& response, const SweepRow& row, double light) {
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

double exposure_of(const SweepProblem& problem, std::span<const double> error, int image) {
  return problem.exposures[image] * (1 + error[image]);
}

/// The light of a cell that fits its rows best, and the rows under it.
double scene_light(const SweepTrack& track, const SweepProblem& problem, const Response& response,
                   std::span<const double> exposure_error, std::vector<Predicted>& rows) {
  rows.resize(track.size());
  const SweepRow& brightest = *std::max_element(
      track.begin(), track.end(), [](const SweepRow& one, const SweepRow& other) { return one.value < other.value; });
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

Normal normal_equations(const SweepProblem& problem, const SweepEstimate& now) {
  const int n = now.response.unknowns(), images = static_cast<int>(problem.exposures.size());
  Normal normal{Eigen::MatrixXd::Zero(n + images, n + images), Eigen::VectorXd::Zero(n + images)};
  std::vector<Predicted> rows;
  for (const SweepTrack& track : problem.tracks) {
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

void add_priors(const SweepProblem& problem, const SweepEstimate& now, Normal& normal) {
  const int n = now.response.unknowns();
  if (problem.dark) {
    const DarkLevel dark = without_bend(*problem.dark, now.response);
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
double improve(const SweepProblem& problem, SweepEstimate& now, Eigen::VectorXd& exposure_variance) {
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

}  // namespace

DarkLevel without_bend(DarkLevel dark, const Response& response) {
  const LightOfValue g = response(response.value(0, dark.value));
  const double shift = 0.5 * g.bend / std::max(g.slope, kSmallestSlope) * dark.pixel_variance;
  dark.value += shift;
  dark.sigma = std::hypot(dark.sigma, kBendDoubt * shift);
  return dark;
}

SweepEstimate estimate(const SweepProblem& problem, const Response& start) {
  SweepEstimate now{.response = start, .exposure_sigma = kSmallestExposureSigma};
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

std::vector<double> track_errors(const std::vector<SweepTrack>& tracks, const SweepProblem& problem,
                                 const SweepEstimate& fit, bool weighted) {
  std::vector<double> errors;
  std::vector<Predicted> rows;
  for (const SweepTrack& track : tracks) {
    scene_light(track, problem, fit.response, fit.exposure_error, rows);
    double sum = 0;
    for (const Predicted& row : rows)
      sum += weighted ? row.weight * row.residual * row.residual : std::pow(row.residual / kLevel, 2);
    errors.push_back(sum / double(track.size() - 1));
  }
  return errors;
}

}  // namespace sheen
