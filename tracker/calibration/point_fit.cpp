// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/point_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace sheen {
namespace {

constexpr int kRounds = 5;                   // of Gauss-Newton; the closed form is nearly there
constexpr std::size_t kMostTriples = 20000;  // looked at, spread evenly over all of them
constexpr double kPriorOfSearch = 4;         // degrees of freedom
constexpr double kLeastTriangle = 0.05;      // height of three points, of their longest side: less is a line

double weight_of(const PointPair& pair) {
  return 3 / pair.covariance.trace();
}

Similarity closed_form(std::span<const PointPair> pairs, std::span<const int> used, const ScaleRule& rule) {
  std::vector<Eigen::Vector3d> source, target;
  std::vector<double> weights;
  Eigen::Vector3d source_mean = Eigen::Vector3d::Zero(), target_mean = Eigen::Vector3d::Zero();
  double total = 0;
  for (const int i : used) {
    source.push_back(pairs[i].mesh);
    target.push_back(pairs[i].stage);
    weights.push_back(weight_of(pairs[i]));
    source_mean += weights.back() * source.back();
    target_mean += weights.back() * target.back();
    total += weights.back();
  }
  Similarity fit = fit_similarity(source, target, weights);
  if (rule.free) return fit;
  fit.scale = rule.scale;
  fit.translation = (target_mean - fit.scale * (fit.rotation * source_mean)) / total;
  return fit;
}

bool is_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double longest = std::max({(a - b).norm(), (b - c).norm(), (c - a).norm()});
  return (b - a).cross(c - a).norm() > kLeastTriangle * longest * longest;
}

/// Sum of the smaller half of the squared residuals, and who they are of.
double trimmed_squares(std::span<const PointPair> pairs, const Similarity& fit, std::size_t half,
                       std::vector<int>& order) {
  std::vector<double> squares;
  for (const PointPair& pair : pairs) squares.push_back(weight_of(pair) * (pair.stage - fit * pair.mesh).squaredNorm());
  order.resize(pairs.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return squares[a] < squares[b]; });
  double sum = 0;
  for (std::size_t i = 0; i < half; ++i) sum += squares[order[i]];
  return sum;
}

std::vector<int> best_half(std::span<const PointPair> pairs, const ScaleRule& rule) {
  const std::size_t n = pairs.size(), half = std::max<std::size_t>(3, n / 2 + 1);
  const std::size_t triples = n * (n - 1) * (n - 2) / 6, stride = 1 + triples / kMostTriples;
  std::vector<int> best(half), order;
  std::iota(best.begin(), best.end(), 0);
  double least = HUGE_VAL;
  std::size_t number = 0;
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b)
      for (std::size_t c = b + 1; c < n; ++c) {
        if (number++ % stride != 0 || !is_triangle(pairs[a].mesh, pairs[b].mesh, pairs[c].mesh)) continue;
        const int triple[] = {static_cast<int>(a), static_cast<int>(b), static_cast<int>(c)};
        const double sum = trimmed_squares(pairs, closed_form(pairs, triple, rule), half, order);
        if (sum >= least) continue;
        least = sum;
        best.assign(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half));
      }
  return best;
}

}  // namespace

PointFit fit_points(std::span<const PointPair> pairs, std::span<const int> used, const ScaleRule& rule) {
  const int n = rule.free ? 7 : 6;
  PointFit fit{.stage_from_mesh = closed_form(pairs, used, rule)};
  for (const int i : used) fit.centre += pairs[i].stage / static_cast<double>(used.size());
  fit.degrees_of_freedom = 3 * static_cast<int>(used.size()) - n;
  for (int round = 0; round <= kRounds; ++round) {
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    fit.squares = 0;
    for (const int i : used) {
      const Eigen::Vector3d at = fit.stage_from_mesh * pairs[i].mesh, residual = pairs[i].stage - at;
      const Eigen::Matrix3d weight = pairs[i].covariance.inverse();
      const Eigen::MatrixXd row = point_derivative(at, fit.centre).leftCols(n);
      information += row.transpose() * weight * row;
      right += row.transpose() * weight * residual;
      fit.squares += residual.dot(weight * residual);
    }
    const Eigen::LDLT<Eigen::MatrixXd> solver(information);
    if (round == kRounds) {
      fit.covariance.topLeftCorner(n, n) = solver.solve(Eigen::MatrixXd::Identity(n, n));
      break;
    }
    PlacementStep step = PlacementStep::Zero();
    step.head(n) = solver.solve(right);
    fit.stage_from_mesh = moved(fit.stage_from_mesh, fit.centre, step);
  }
  return fit;
}

double sigmas_off(const PointPair& pair, const PointFit& fit, double factor) {
  const Eigen::Vector3d at = fit.stage_from_mesh * pair.mesh, residual = pair.stage - at;
  const Eigen::Matrix<double, 3, 7> row = point_derivative(at, fit.centre);
  const Eigen::Matrix3d covariance = factor * (pair.covariance + row * fit.covariance * row.transpose());
  return std::sqrt(residual.dot(covariance.ldlt().solve(residual)) / 3);
}

double variance_factor(const PointFit& fit, double prior) {
  return (prior + fit.squares) / (prior + fit.degrees_of_freedom);
}

std::vector<int> consensus(std::span<const PointPair> pairs, const ScaleRule& rule, bool known, double outlier_sigmas) {
  std::vector<int> inside = best_half(pairs, rule);
  while (inside.size() < pairs.size()) {
    const PointFit fit = fit_points(pairs, inside, rule);
    const double factor = known ? 1 : variance_factor(fit, kPriorOfSearch);
    int nearest = -1;
    double least = outlier_sigmas;
    for (int i = 0; i < static_cast<int>(pairs.size()); ++i) {
      if (std::find(inside.begin(), inside.end(), i) != inside.end()) continue;
      const double off = sigmas_off(pairs[i], fit, factor);
      if (off < least) least = off, nearest = i;
    }
    if (nearest < 0) break;
    inside.push_back(nearest);
  }
  std::sort(inside.begin(), inside.end());
  return inside;
}

}  // namespace sheen
