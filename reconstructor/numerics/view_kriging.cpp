// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/view_kriging.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace sheen {

float angle_between(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return 2 * std::atan2((a - b).norm(), (a + b).norm());
}

float evaluate(const ViewKernel& kernel, float angle) {
  const float t = std::sqrt(3.0f) * angle / kernel.scale_rad;
  return (1 + t) * std::exp(-t);
}

ViewInterpolant krige(const Eigen::Matrix3Xf& directions, const Eigen::Ref<const Eigen::MatrixXf>& coefficients,
                      const Eigen::Ref<const Eigen::VectorXf>& reliability, const ViewKernel& kernel) {
  const Eigen::Index n = directions.cols();
  ViewInterpolant result;
  result.mean = Eigen::VectorXf::Zero(coefficients.rows());
  result.weights = Eigen::MatrixXf::Zero(coefficients.rows(), n);
  if (n == 0) return result;

  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    covariance(i, i) = 1 + kernel.nugget / reliability[i];
    for (Eigen::Index j = 0; j < i; ++j)
      covariance(i, j) = covariance(j, i) = evaluate(kernel, angle_between(directions.col(i), directions.col(j)));
  }
  const Eigen::MatrixXd q = covariance.llt().solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::VectorXd row_sums = q.rowwise().sum();
  const double total = row_sums.sum();
  const Eigen::MatrixXd y = coefficients.cast<double>();
  result.mean = (y * row_sums / total).cast<float>();
  if (n == 1) return result;
  // Z = Q - Q 1 1^T Q / (1^T Q 1): h(d) = mean + (Y Z) k(d), and the error of view i left out is (Y Z)_i / Z_ii.
  const Eigen::MatrixXd z = q - row_sums * row_sums.transpose() / total;
  const Eigen::MatrixXd weights = y * z;
  result.weights = weights.cast<float>();
  for (Eigen::Index i = 0; i < n; ++i) result.leave_one_out += weights.col(i).squaredNorm() / (z(i, i) * z(i, i));
  return result;
}

Eigen::VectorXf interpolate(const ViewInterpolant& interpolant, const Eigen::Matrix3Xf& directions,
                            const ViewKernel& kernel, const Eigen::Vector3f& direction) {
  Eigen::VectorXf k(directions.cols());
  for (Eigen::Index j = 0; j < k.size(); ++j) k[j] = evaluate(kernel, angle_between(directions.col(j), direction));
  return interpolant.mean + interpolant.weights * k;
}

}  // namespace sheen
