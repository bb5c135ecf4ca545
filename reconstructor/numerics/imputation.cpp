// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/imputation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace sheen {

using Eigen::MatrixXd;

MatrixXd prior_precision(const MatrixXd& prior, double noise) {
  // Floors: directions that have hardly been used stay invertible, and a few known rows without noise stay finite.
  constexpr double kLeastShare = 1e-6, kLeastNoise = 1e-12;
  const Eigen::Index rank = prior.rows();
  MatrixXd covariance = prior;
  covariance.diagonal().array() += std::max(kLeastShare * prior.diagonal().mean(), 1e-300);
  return std::max(noise, kLeastNoise * prior.trace()) * covariance.llt().solve(MatrixXd::Identity(rank, rank));
}

Eigen::VectorXd most_probable_coefficients(const Eigen::Ref<const MatrixXd>& known,
                                           const Eigen::Ref<const Eigen::VectorXd>& projection,
                                           const MatrixXd& precision) {
  // b^2 of the dimmest row that still tells how bright its column is: y = c / b then, from a projection b c.
  constexpr double kDimmest = 1e-6;
  MatrixXd normal = known + precision;
  normal.diagonal().array() += std::max(1e-9 * normal.diagonal().mean(), 1e-300);
  const Eigen::LLT<Eigen::Ref<MatrixXd>> cholesky(normal);
  if (cholesky.info() == Eigen::Success)
    if (const Eigen::VectorXd y = cholesky.solve(projection); y.allFinite())
      return std::min(1.0, projection.norm() / (kDimmest * std::max(y.norm(), 1e-300))) * y;
  return Eigen::VectorXd::Zero(projection.size());
}

Eigen::VectorXd least_squares_coefficients(const Eigen::Ref<const MatrixXd>& known,
                                           const Eigen::Ref<const Eigen::VectorXd>& projection, const MatrixXd& prior) {
  constexpr double kLeastShare = 1e-6;    // of the prior, as above
  constexpr double kUndetermined = 1e-9;  // of the largest: what the known rows say nothing about
  MatrixXd covariance = prior;
  covariance.diagonal().array() += std::max(kLeastShare * prior.diagonal().mean(), 1e-300);
  const MatrixXd scale = covariance.llt().matrixL();  // y = scale x: the Mahalanobis norm of y is the norm of x
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scale.transpose() * known * scale);
  const double least = kUndetermined * std::max(eigen.eigenvalues().maxCoeff(), 1e-300);
  const Eigen::VectorXd inverse = eigen.eigenvalues().unaryExpr([&](double e) { return e > least ? 1 / e : 0.0; });
  return scale * (eigen.eigenvectors() *
                  inverse.cwiseProduct(eigen.eigenvectors().transpose() * (scale.transpose() * projection)));
}

}  // namespace sheen
