// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/view_kriging.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace sheen {
namespace {

/// A drift that the views hardly tell from a constant cannot be fitted.
constexpr double kLeastDrift = 1e-6;

/// Ordinary kriging in matrices: with Q the inverse of the covariance, Z = Q - Q 1 1^T Q / (1^T Q 1).
struct Dual {
  Eigen::MatrixXd z;
  Eigen::VectorXd row_sums;  ///< Q 1
  double total = 0;          ///< 1^T Q 1
};

Dual dual_of(const Eigen::Matrix3Xf& directions, const Eigen::Ref<const Eigen::VectorXf>& reliability,
             const ViewKernel& kernel) {
  const Eigen::Index n = directions.cols();
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    covariance(i, i) = 1 + kernel.nugget / reliability[i];
    for (Eigen::Index j = 0; j < i; ++j)
      covariance(i, j) = covariance(j, i) = evaluate(kernel, angle_between(directions.col(i), directions.col(j)));
  }
  Dual dual;
  dual.z = covariance.llt().solve(Eigen::MatrixXd::Identity(n, n));
  dual.row_sums = dual.z.rowwise().sum();
  dual.total = dual.row_sums.sum();
  dual.z -= dual.row_sums * dual.row_sums.transpose() / dual.total;
  return dual;
}

/// The drift projected out as well: Z - Z f f^T Z / (f^T Z f). Returns Z f / (f^T Z f), whose product with the
/// coefficients is the factor of the drift; empty where the drift says nothing that a constant does not.
Eigen::VectorXd project_out(const Eigen::VectorXd& drift, Eigen::MatrixXd& z) {
  const Eigen::VectorXd zf = z * drift;
  const double power = drift.dot(zf);
  if (!(power > kLeastDrift)) return {};
  z -= zf * zf.transpose() / power;
  return zf / power;
}

double weighted_error(const Eigen::MatrixXd& weights, const Eigen::MatrixXd& z,
                      const Eigen::Ref<const Eigen::VectorXf>& reliability) {
  constexpr double kLeastDiagonal = 1e-9;  // of a view that alone decides: nothing is left to predict it from
  double error = 0;
  for (Eigen::Index i = 0; i < z.cols(); ++i) {
    const double diagonal = std::max(z(i, i), kLeastDiagonal);
    error += reliability[i] * weights.col(i).squaredNorm() / (diagonal * diagonal);
  }
  return error;
}

}  // namespace

float angle_between(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return 2 * std::atan2((a - b).norm(), (a + b).norm());
}

float evaluate(const ViewKernel& kernel, float angle) {
  if (kernel.shape == KernelShape::kExponential) return std::exp(-angle / kernel.scale_rad);
  const float t = std::sqrt(3.0f) * angle / kernel.scale_rad;
  return (1 + t) * std::exp(-t);
}

ViewInterpolant krige(const Eigen::Matrix3Xf& directions, const Eigen::Ref<const Eigen::MatrixXf>& coefficients,
                      const Eigen::Ref<const Eigen::VectorXf>& reliability, const ViewKernel& kernel,
                      const Eigen::VectorXf& drift) {
  const Eigen::Index n = directions.cols();
  ViewInterpolant result;
  result.mean = Eigen::VectorXf::Zero(coefficients.rows());
  result.weights = Eigen::MatrixXf::Zero(coefficients.rows(), n);
  if (n == 0) return result;

  Dual dual = dual_of(directions, reliability, kernel);
  Eigen::MatrixXd y = coefficients.cast<double>();
  Eigen::VectorXd factor;
  if (n > 2 && drift.size() > 0) {
    const Eigen::VectorXd f = drift.cast<double>();
    const Eigen::VectorXd projector = project_out(f, dual.z);
    if (projector.size() > 0) {
      factor = y * projector;
      result.drift = factor.cast<float>();
    }
  }
  // h(d) = mean + factor f(d) + (Y Z) k(d), and the error of view i left out is (Y Z)_i / Z_ii.
  const Eigen::MatrixXd weights = y * dual.z;
  if (factor.size() > 0) y -= factor * drift.cast<double>().transpose();
  result.mean = (y * dual.row_sums / dual.total).cast<float>();
  if (n == 1) return result;
  result.weights = weights.cast<float>();
  result.leave_one_out = weighted_error(weights, dual.z, reliability);
  return result;
}

LeaveOneOut leave_one_out(const Eigen::Matrix3Xf& directions, const Eigen::Ref<const Eigen::MatrixXf>& coefficients,
                          const Eigen::Ref<const Eigen::VectorXf>& reliability, const ViewKernel& kernel,
                          const Eigen::VectorXf& drift) {
  LeaveOneOut errors;
  errors.with_drift = std::numeric_limits<double>::infinity();
  if (directions.cols() < 2) return errors;
  Dual dual = dual_of(directions, reliability, kernel);
  const Eigen::MatrixXd y = coefficients.cast<double>();
  Eigen::MatrixXd weights = y * dual.z;
  errors.ordinary = weighted_error(weights, dual.z, reliability);
  if (directions.cols() < kFewestViewsWithDrift || drift.size() == 0) return errors;
  const Eigen::VectorXd zf = dual.z * drift.cast<double>();
  const Eigen::VectorXd projector = project_out(drift.cast<double>(), dual.z);
  if (projector.size() == 0) return errors;
  weights -= (y * projector) * zf.transpose();
  errors.with_drift = weighted_error(weights, dual.z, reliability);
  return errors;
}

Eigen::VectorXf interpolate(const ViewInterpolant& interpolant, const Eigen::Matrix3Xf& directions,
                            const ViewKernel& kernel, const Eigen::Vector3f& direction) {
  Eigen::VectorXf k(directions.cols());
  for (Eigen::Index j = 0; j < k.size(); ++j) k[j] = evaluate(kernel, angle_between(directions.col(j), direction));
  return interpolant.mean + interpolant.weights * k;
}

}  // namespace sheen
