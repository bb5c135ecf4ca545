// SPDX-License-Identifier: Apache-2.0
#include "common/registration/placement_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace sheen {
namespace {

constexpr double kUndetermined = 5e-3;  // curvature of a direction, of the best known one: less is chance of the pixels
constexpr double kRidge = 1e-6;         // keeps such directions where they are
constexpr double kLeastDamping = 1e-4, kMostDamping = 1e4;
constexpr double kFewGroups = 10;    // what a covariance from hardly more groups than parameters is multiplied by
constexpr double kMostStretch = 64;  // of a step: noise in the images makes J^T J too large, and steps too short

struct Sum {
  PlacementMatrix information = PlacementMatrix::Zero();
  PlacementStep gradient = PlacementStep::Zero();
  double cost = HUGE_VAL;
  std::size_t residuals = 0;
};

/// In lengths: a rotation or a scale counts as what it moves a point by that is `radius` from the centre.
PlacementStep lengths(double radius) {
  PlacementStep unit = PlacementStep::Ones();
  unit.head<3>().setConstant(1 / radius);
  unit[6] = 1 / radius;
  return unit;
}

/// `cost`: of the placement that the gradient is for, where it is not that of these equations.
Sum sum_of(const std::vector<ImageEquations>& images, const FitOptions& options, std::optional<double> cost = {}) {
  ImageEquations all;
  for (const ImageEquations& image : images) all += image;
  Sum sum{.information = all.information, .gradient = all.gradient, .residuals = all.residuals};
  if (all.scale > 0) {
    sum.cost = all.loss / all.scale;
    sum.gradient -= cost.value_or(sum.cost) * all.scale_gradient;
  }
  const PlacementStep unit = lengths(options.radius);
  sum.information = unit.asDiagonal() * sum.information * unit.asDiagonal();
  sum.gradient = unit.asDiagonal() * sum.gradient;
  if (!options.free_scale) {
    sum.information.row(6).setZero();
    sum.information.col(6).setZero();
    sum.gradient[6] = 0;
  }
  return sum;
}

/// By how much a covariance from so few groups is too small on average, for the squared error in its units to be the
/// number of parameters (the mean of Hotelling's T^2).
double few_groups_factor(double groups, int parameters) {
  return groups - parameters > 3 ? groups / (groups - parameters - 2) : kFewGroups;
}

/// Second derivative of half the loss, in lengths.
Eigen::MatrixXd curvature(const Equations& equations, const FitOptions& options, const PlacementFit& fit) {
  const int n = options.free_scale ? 7 : 6;
  const PlacementStep unit = lengths(options.radius);
  Eigen::MatrixXd second(n, n);
  const auto gradient = [&](int i, double by) {
    const PlacementStep step = by * unit.cwiseProduct(PlacementStep::Unit(i));
    const Sum there = sum_of(equations(moved(fit.stage_from_mesh, options.centre, step)), options, fit.cost);
    return Eigen::VectorXd(there.gradient.head(n));
  };
  for (int i = 0; i < n; ++i)
    second.col(i) = (gradient(i, options.probe_m) - gradient(i, -options.probe_m)) / (2 * options.probe_m);
  return (second + second.transpose()) / 2;
}

/// The inverse of a curvature in the directions that the images determine, and the others, a column each.
struct Inverse {
  Eigen::MatrixXd inverse, unknown;
};

Inverse inverse_where_known(const Eigen::MatrixXd& curvature) {
  const auto n = curvature.cols();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(curvature);
  Eigen::Index flat = 0;
  while (flat < n && solver.eigenvalues()[flat] <= kUndetermined * solver.eigenvalues()[n - 1]) ++flat;
  const Eigen::MatrixXd bent = solver.eigenvectors().rightCols(n - flat);
  return {bent * solver.eigenvalues().tail(n - flat).cwiseInverse().asDiagonal() * bent.transpose(),
          solver.eigenvectors().leftCols(flat)};
}

void set_covariance(const std::vector<ImageEquations>& images, const Equations& equations, const FitOptions& options,
                    PlacementFit& fit) {
  const int n = options.free_scale ? 7 : 6;
  const PlacementStep unit = lengths(options.radius);
  const Eigen::MatrixXd information = curvature(equations, options, fit);
  std::map<int, Eigen::VectorXd> gradients;  // per group
  Eigen::VectorXd common = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (images[i].residuals == 0) continue;
    const int group = options.groups.empty() ? static_cast<int>(i) : options.groups[i];
    Eigen::VectorXd& sum = gradients.try_emplace(group, Eigen::VectorXd::Zero(n)).first->second;
    sum += (unit.asDiagonal() * (images[i].gradient - fit.cost * images[i].scale_gradient)).head(n);
    common += options.common_error * (unit.asDiagonal() * images[i].common).head(n);
  }
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(n, n);
  for (const auto& [group, gradient] : gradients) scatter += gradient * gradient.transpose();
  scatter *= few_groups_factor(static_cast<double>(gradients.size()), n);
  scatter += common * common.transpose();
  const Inverse known = inverse_where_known(information);
  fit.undetermined = static_cast<int>(known.unknown.cols());
  const Eigen::MatrixXd covariance = known.inverse * scatter * known.inverse +
                                     options.radius * options.radius * known.unknown * known.unknown.transpose();
  fit.covariance.setZero();
  fit.covariance.topLeftCorner(n, n) = covariance;
  fit.covariance.diagonal().head(n).array() += std::pow(options.common_move_m, 2);
  fit.covariance = unit.asDiagonal() * fit.covariance * unit.asDiagonal();
}

}  // namespace

ImageEquations& ImageEquations::operator+=(const ImageEquations& other) {
  information += other.information;
  gradient += other.gradient;
  loss += other.loss;
  scale += other.scale;
  scale_gradient += other.scale_gradient;
  common += other.common;
  residuals += other.residuals;
  return *this;
}

PlacementFit fit_placement(const Similarity& start, const Equations& equations, const FitOptions& options) {
  PlacementFit fit{.stage_from_mesh = start};
  const PlacementStep unit = lengths(options.radius);
  std::vector<ImageEquations> images = equations(start);
  Sum sum = sum_of(images, options);
  double damping = 1e-2, stretch = 1;
  for (int step = 0; step < options.most_steps && sum.residuals > 0 && damping < kMostDamping; ++step) {
    const double mean_information = sum.information.trace() / 7;
    if (!(mean_information > 0)) break;
    PlacementMatrix damped = sum.information;
    damped.diagonal().array() += kRidge * mean_information;
    damped.diagonal() += damping * sum.information.diagonal();
    const PlacementStep change = -stretch * damped.ldlt().solve(sum.gradient);
    const Similarity candidate = moved(fit.stage_from_mesh, options.centre, unit.asDiagonal() * change);
    std::vector<ImageEquations> images_there = equations(candidate);
    const Sum there = sum_of(images_there, options);
    // Most of the residuals must stay, or a mesh that leaves the images would be the best fit.
    const bool near = step_between(start, candidate, options.centre).cwiseQuotient(unit).norm() <= options.reach_m;
    if (near && there.cost <= sum.cost && 2 * there.residuals > sum.residuals) {
      fit.stage_from_mesh = candidate;
      images = std::move(images_there);
      sum = there;
      damping = std::max(kLeastDamping, damping / 10);
      stretch = std::min(kMostStretch, 2 * stretch);
    } else if (stretch > 1) {
      stretch = std::max(1.0, stretch / 4);
    } else {
      damping *= 10;
    }
    if (change.norm() < options.enough_m) break;
  }
  fit.residuals = sum.residuals;
  if (sum.residuals == 0) return fit;
  fit.cost = sum.cost;
  set_covariance(images, equations, options, fit);
  return fit;
}

}  // namespace sheen
