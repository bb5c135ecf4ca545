// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace sheen {

/// Generalised covariances of the distance r, of growing smoothness (polyharmonic splines). They have no scale: sparse
/// points are interpolated as dense ones are. Saved models name them by these numbers.
enum class PointKernelShape {
  kLinear = 0,     ///< -r
  kThinPlate = 1,  ///< r^2 log r
  kCubic = 2,      ///< r^3
};

/// How values at points in space are interpolated between them.
struct PointKernel {
  PointKernelShape shape = PointKernelShape::kCubic;
  int drift_degree = 1;  ///< harmonic polynomials up to this degree are reproduced exactly: 1, 2 or 3
  float depth = 1;       ///< distances along z count this much
  bool operator==(const PointKernel&) const = default;
};

/// Universal kriging of values at points, in its primal form: every prediction is a weighted sum of the values, with
/// weights that depend on places alone. All values that were measured at the same points share them. The nugget is 0:
/// values at the points are reproduced.
class PointKriging {
 public:
  /// points: 3 x n, n >= 1, no two the same where the kernel's distance is meant. Drift functions that the points
  /// cannot tell apart are left out.
  PointKriging(const Eigen::Matrix3Xd& points, const PointKernel& kernel);

  const PointKernel& kernel() const { return kernel_; }
  /// n; they sum to 1.
  Eigen::VectorXf weights(const Eigen::Vector3d& point) const;
  /// Row i times the values is the error of predicting value i from the others (closed form); n x n. Points without
  /// which the drift cannot be found have rows of zeros.
  const Eigen::MatrixXf& leave_one_out() const { return leave_one_out_; }

 private:
  Eigen::MatrixXd points_;  ///< 3 x n, as distances are measured
  Eigen::Vector3d centre_;  ///< of the drift's coordinates
  double scale_ = 1;        ///< of these, too
  PointKernel kernel_;
  std::vector<int> drift_;    ///< which drift functions are in use
  Eigen::MatrixXd solution_;  ///< n x (n + drift): of the kriging system, those rows that give the weights
  Eigen::MatrixXf leave_one_out_;
};

/// Of these kernels the one with the least sum over points of squared errors of predicting each value from the others.
/// gram: n x n, the products of the points' values with each other, summed over all that was measured.
PointKernel choose_kernel(const Eigen::Matrix3Xd& points, const Eigen::MatrixXd& gram,
                          std::span<const PointKernel> kernels);

/// Mean square error of predicting a value from the others: trace(L gram L^T) / n.
double mean_leave_one_out(const PointKriging& kriging, const Eigen::MatrixXd& gram);

}  // namespace sheen
