// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/vignette_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/errors.h"

namespace sheen {
namespace {

constexpr int kLens = 5;  ///< k1 k2 k3 cx cy
constexpr int kLightDegree = 6;
constexpr int kIterations = 25, kRejections = 2;
constexpr double kConverged = 1e-10;
constexpr double kCoefficientPrior = 2, kLightPrior = 10, kCentrePrior = 0.1;  ///< the centre's: in half diagonals
constexpr double kFlat = 0.03, kClipSigmas = 4, kNearSaturation = 0.005;
constexpr double kDarkest = 0.02;     ///< value below which a cell says little
constexpr double kLeastNoise = 0.05;  ///< what a perfect fit may say of the variances of the pixels
constexpr double kOutlier = 5;        ///< standard deviations
constexpr double kDetermined = 0.02;
constexpr int kRings = 10, kMapSteps = 16;
constexpr int kFewestCells = 50;

struct Sample {
  int image = 0;
  Eigen::Vector2d pixel, target;  ///< half diagonals from the image's middle
  double spread = 0;              ///< of a cell: a sixth of its side squared
  double log_light = 0, variance = 0;
  std::array<double, 3> channels{};  ///< logarithms of their light
};

struct Geometry {
  ImageSize size;
  double half = 1;  ///< diagonal, pixels
  Eigen::Vector2d middle;
  explicit Geometry(ImageSize s)
      : size(s), half(0.5 * std::hypot(s.width, s.height)), middle((s.width - 1) / 2.0, (s.height - 1) / 2.0) {}
};

/// Light and variance of its logarithm of a cell's mean value; a negative light where it cannot be used.
std::array<double, 2> log_light(const CellValue& cell, const Response& response, double saturation, int levels) {
  const double sigma = std::sqrt(cell.variance);
  const bool usable = cell.mean > kDarkest && cell.mean - kClipSigmas * sigma > 0 && sigma < kFlat &&
                      cell.mean + kClipSigmas * sigma < saturation * (1 - kNearSaturation);
  const LightOfValue g = response(cell.mean);
  const double light = g.light + 0.5 * g.bend * cell.variance;
  if (!usable || light <= 0) return {-1, 0};
  const double relative = g.slope / light;
  return {std::log(light), relative * relative * cell.mean_variance(levels)};
}

std::vector<Sample> samples_of(std::span<const FlatImage> flats, const Response& response, double saturation,
                               const Geometry& geometry, int& unused) {
  std::vector<Sample> samples;
  for (std::size_t m = 0; m < flats.size(); ++m) {
    const CellImage& cells = flats[m].cells;
    const Eigen::Rotation2Dd back(-flats[m].move.turn_rad);
    for (int row = 0; row < cells.rows; ++row)
      for (int column = 0; column < cells.columns; ++column) {
        Sample sample{.image = static_cast<int>(m)};
        bool usable = true;
        for (int c = 0; c < cells.channels; ++c) {
          const auto [light, variance] = log_light(cells.at(column, row, c), response, saturation, cells.levels);
          usable &= variance > 0;
          sample.channels[c] = light;
          sample.log_light += light / cells.channels;
          sample.variance += variance / (cells.channels * cells.channels);
        }
        if (!usable) {
          ++unused;
          continue;
        }
        const Eigen::Vector2d from_middle = Eigen::Vector2d(cells.x(column), cells.y(row)) - geometry.middle;
        sample.pixel = from_middle / geometry.half;
        sample.spread = std::pow(cells.cell_px / geometry.half, 2) / 6;
        sample.target = back * (from_middle - flats[m].move.shift_px) / geometry.half;
        samples.push_back(sample);
      }
  }
  return samples;
}

/// x^i y^j of all degrees from 1 to kLightDegree.
int light_terms(TargetLight light) {
  return light == TargetLight::kEven ? 0 : (kLightDegree + 1) * (kLightDegree + 2) / 2 - 1;
}

using Lens = Eigen::Matrix<double, kLens, 1>;  ///< k1 k2 k3, centre in half diagonals from the middle

/// The logarithm of the vignette and its derivatives. `spread`: by which the mean of r^2 over a cell is more than at
/// its middle.
double log_vignette(const Lens& lens, const Eigen::Vector2d& pixel, double spread, Lens* gradient) {
  const Eigen::Vector2d from = pixel - lens.tail<2>();
  const double r2 = from.squaredNorm() + spread;
  const double v = std::max(1 + r2 * (lens[0] + r2 * (lens[1] + r2 * lens[2])), 0.01);
  if (gradient) {
    const double by_r2 = lens[0] + r2 * (2 * lens[1] + 3 * r2 * lens[2]);
    *gradient << r2 / v, r2 * r2 / v, r2 * r2 * r2 / v, -2 * from.x() * by_r2 / v, -2 * from.y() * by_r2 / v;
  }
  return std::log(v);
}

/// All that is estimated: the lens, the gain of each image, the light on the target.
struct Solution {
  Eigen::VectorXd numbers;
  Eigen::MatrixXd covariance;
  double rms = 0;  ///< of residuals
  Lens lens() const { return numbers.head<kLens>(); }
};

struct Design {
  int images = 0, terms = 0;

  int size() const { return kLens + images + terms; }
  /// Derivatives of a sample's logarithm, and what is predicted of it.
  double row(const Sample& sample, const Eigen::VectorXd& numbers, Eigen::VectorXd& out) const {
    out.setZero(size());
    Lens gradient;
    double predicted = log_vignette(numbers.head<kLens>(), sample.pixel, sample.spread, &gradient);
    out.head<kLens>() = gradient;
    out[kLens + sample.image] = 1;
    predicted += numbers[kLens + sample.image];
    for (int degree = 1, at = kLens + images; degree <= kLightDegree && terms > 0; ++degree)
      for (int j = 0; j <= degree; ++j, ++at) {
        out[at] = std::pow(sample.target.x(), degree - j) * std::pow(sample.target.y(), j);
        predicted += numbers[at] * out[at];
      }
    return predicted;
  }
};

Solution solve(const std::vector<Sample>& samples, const Design& design) {
  Eigen::VectorXd prior = Eigen::VectorXd::Zero(design.size());  // of the inverse variances
  prior.head<3>().setConstant(1 / (kCoefficientPrior * kCoefficientPrior));
  prior.segment<2>(3).setConstant(1 / (kCentrePrior * kCentrePrior));
  prior.tail(design.terms).setConstant(1 / (kLightPrior * kLightPrior));
  Solution result{.numbers = Eigen::VectorXd::Zero(design.size())};
  for (const Sample& s : samples) result.numbers[kLens + s.image] = s.log_light;
  Eigen::VectorXd row;
  double noise2 = 1;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(design.size(), design.size());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(design.size());
    double chi2 = 0, squares = 0;
    for (const Sample& s : samples) {
      const double residual = s.log_light - design.row(s, result.numbers, row), w = 1 / s.variance;
      normal.selfadjointView<Eigen::Lower>().rankUpdate(row, w);
      right += w * residual * row;
      chi2 += w * residual * residual;
      squares += residual * residual;
    }
    const double count = static_cast<double>(samples.size());
    result.rms = std::sqrt(squares / count);
    noise2 = std::max(kLeastNoise, chi2 / std::max(1.0, count - design.size()));
    normal.triangularView<Eigen::StrictlyUpper>() = normal.transpose();
    normal /= noise2;
    normal.diagonal() += prior;
    right = right / noise2 - prior.cwiseProduct(result.numbers);
    const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
    const Eigen::VectorXd step = solver.solve(right);
    if (!step.allFinite()) throw Error("the vignette cannot be estimated from these images");
    const double most = step.head<kLens>().cwiseAbs().maxCoeff();
    result.numbers += std::min(1.0, 0.5 / std::max(most, 1e-12)) * step;
    result.covariance = solver.solve(Eigen::MatrixXd::Identity(design.size(), design.size()));
    if (most < kConverged) break;
  }
  return result;
}

std::vector<double> residuals_of(const std::vector<Sample>& samples, const Design& design, const Solution& solution) {
  std::vector<double> residuals;
  Eigen::VectorXd row;
  for (const Sample& s : samples) residuals.push_back(s.log_light - design.row(s, solution.numbers, row));
  return residuals;
}

/// Dust, an edge of the target, a shadow.
int drop_outliers(std::vector<Sample>& samples, const Design& design, const Solution& solution) {
  const std::vector<double> residuals = residuals_of(samples, design, solution);
  std::vector<Sample> kept;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (std::abs(residuals[i]) <= kOutlier * solution.rms) kept.push_back(samples[i]);
  const auto dropped = static_cast<int>(samples.size() - kept.size());
  samples = std::move(kept);
  return dropped;
}

/// What is left in rings round the centre, of all colours together and of each against them.
void look_at_rings(const std::vector<Sample>& samples, const Design& design, const Solution& solution, int channels,
                   VignetteFit& fit) {
  const std::vector<double> residuals = residuals_of(samples, design, solution);
  double farthest = 0;
  for (const Sample& s : samples) farthest = std::max(farthest, (s.pixel - solution.lens().tail<2>()).norm());
  std::array<std::array<double, 4>, kRings> sums{};
  std::array<double, kRings> counts{};
  std::array<double, 3> all{};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double r = (samples[i].pixel - solution.lens().tail<2>()).norm();
    const int ring = std::min(kRings - 1, static_cast<int>(kRings * r / farthest));
    ++counts[ring];
    sums[ring][3] += residuals[i];
    for (int c = 0; c < channels; ++c) {
      const double difference = samples[i].channels[c] - samples[i].log_light;
      sums[ring][c] += difference;
      all[c] += difference / static_cast<double>(samples.size());
    }
  }
  for (int ring = 0; ring < kRings; ++ring) {
    if (counts[ring] < 4) continue;
    fit.ring_radius.push_back((ring + 0.5) / kRings * farthest);
    fit.ring_residual.push_back(sums[ring][3] / counts[ring]);
    fit.left_radial = std::max(fit.left_radial, std::abs(fit.ring_residual.back()));
    for (int c = 0; c < channels; ++c)
      fit.left_colour = std::max(fit.left_colour, std::abs(sums[ring][c] / counts[ring] - all[c]));
  }
}

}  // namespace

bool VignetteFit::determined() const {
  return worst_uncertainty < kDetermined;
}

double VignetteFit::uncertainty_at(double x, double y) const {
  const Geometry geometry(size);
  const auto lens_at = [&] {
    Lens lens;
    lens << vignette.k[0], vignette.k[1], vignette.k[2], (vignette.cx - geometry.middle.x()) / geometry.half,
        (vignette.cy - geometry.middle.y()) / geometry.half;
    return lens;
  }();
  Lens gradient;
  log_vignette(lens_at, (Eigen::Vector2d(x, y) - geometry.middle) / geometry.half, 0, &gradient);
  gradient.tail<2>() /= geometry.half;  // the covariance is in pixels
  return std::sqrt(std::max(0.0, gradient.dot(covariance * gradient)));
}

VignetteFit fit_vignette(std::span<const FlatImage> flats, const Response& response, double saturation,
                         TargetLight light) {
  if (flats.empty()) throw Error("the vignette needs at least one image of a flat white target");
  const CellImage& first = flats[0].cells;
  for (const FlatImage& flat : flats)
    if (flat.cells.size.width != first.size.width || flat.cells.size.height != first.size.height ||
        flat.cells.channels != first.channels)
      throw Error(flat.cells.name + " differs from " + first.name + " in size or channels; give one camera's images");
  VignetteFit fit{.size = first.size};
  const Geometry geometry(fit.size);
  std::vector<Sample> samples = samples_of(flats, response, saturation, geometry, fit.cells_unused);
  const Design design{static_cast<int>(flats.size()), light_terms(light)};
  const auto fewest = static_cast<std::size_t>(std::max(kFewestCells, 2 * design.size()));
  const auto check_enough = [&] {
    if (samples.size() < fewest)
      throw Error("only " + std::to_string(samples.size()) +
                  " cells of the flat images can be used: the others are too dark, clipped or full of detail");
  };
  check_enough();
  Solution solution = solve(samples, design);
  for (int round = 0; round < kRejections; ++round) {
    fit.cells_unused += drop_outliers(samples, design, solution);
    check_enough();
    solution = solve(samples, design);
  }
  const Lens lens = solution.lens();
  fit.vignette = {geometry.middle.x() + geometry.half * lens[3],
                  geometry.middle.y() + geometry.half * lens[4],
                  {lens[0], lens[1], lens[2]}};
  Lens unit;
  unit << 1, 1, 1, geometry.half, geometry.half;
  fit.covariance = unit.asDiagonal() * solution.covariance.topLeftCorner<kLens, kLens>() * unit.asDiagonal();
  fit.centre_uncertainty_px = std::sqrt(fit.covariance.bottomRightCorner<2, 2>().diagonal().maxCoeff());
  fit.cells_used = static_cast<int>(samples.size());
  fit.rms = solution.rms;
  for (int j = 0; j <= kMapSteps; ++j)
    for (int i = 0; i <= kMapSteps; ++i) {
      const double x = double(fit.size.width - 1) * i / kMapSteps, y = double(fit.size.height - 1) * j / kMapSteps;
      fit.worst_uncertainty = std::max(fit.worst_uncertainty, fit.uncertainty_at(x, y));
      fit.corner = std::min(fit.corner, fit.vignette.at(x, y, fit.size));
    }
  look_at_rings(samples, design, solution, first.channels, fit);
  return fit;
}

}  // namespace sheen
