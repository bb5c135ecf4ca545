// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/point_kriging.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

namespace sheen {
namespace {

constexpr std::array<int, 4> kDriftFunctions{1, 4, 9, 16};  // by degree

/// Harmonic polynomials of degree 0, 1, 2, 3: on a sphere, the real spherical harmonics but for their scale.
Eigen::Matrix<double, 16, 1> drift_functions(const Eigen::Vector3d& p) {
  const double x = p.x(), y = p.y(), z = p.z();
  return {1,
          x,
          y,
          z,
          x * y,
          x * z,
          y * z,
          x * x - y * y,
          2 * z * z - x * x - y * y,
          y * (3 * x * x - y * y),
          x * y * z,
          y * (4 * z * z - x * x - y * y),
          z * (2 * z * z - 3 * x * x - 3 * y * y),
          x * (4 * z * z - x * x - y * y),
          (x * x - y * y) * z,
          x * (x * x - 3 * y * y)};
}

double covariance(PointKernelShape shape, double r) {
  switch (shape) {
    case PointKernelShape::kLinear:
      return -r;
    case PointKernelShape::kThinPlate:
      return r > 0 ? r * r * std::log(r) : 0;
    case PointKernelShape::kCubic:
      break;
  }
  return r * r * r;
}

/// The columns of a matrix that do not follow from those before them.
std::vector<int> independent_columns(const Eigen::MatrixXd& matrix) {
  constexpr double kLeastPart = 1e-6;  // of a column that is its own
  std::vector<int> chosen;
  Eigen::MatrixXd basis(matrix.rows(), matrix.cols());
  for (Eigen::Index j = 0; j < matrix.cols() && chosen.size() < static_cast<std::size_t>(matrix.rows()); ++j) {
    Eigen::VectorXd rest = matrix.col(j);
    const auto used = basis.leftCols(static_cast<Eigen::Index>(chosen.size()));
    for (int twice = 0; twice < 2; ++twice) rest -= used * (used.transpose() * rest).eval();
    if (!(rest.norm() > kLeastPart * matrix.col(j).norm())) continue;
    basis.col(static_cast<Eigen::Index>(chosen.size())) = rest.normalized();
    chosen.push_back(static_cast<int>(j));
  }
  return chosen;
}

}  // namespace

PointKriging::PointKriging(const Eigen::Matrix3Xd& points, const PointKernel& kernel)
    : points_(points), centre_(points.rowwise().mean()), kernel_(kernel) {
  const Eigen::Index n = points.cols();
  scale_ = std::sqrt((points.colwise() - centre_).squaredNorm() / static_cast<double>(n));
  if (!(scale_ > 0)) scale_ = 1;
  // A harmonic polynomial is one about any centre: what is reproduced does not depend on it, only rounding errors do.
  points_.row(2) *= kernel.depth;

  Eigen::MatrixXd drift(n, kDriftFunctions[static_cast<std::size_t>(std::clamp(kernel.drift_degree, 0, 3))]);
  for (Eigen::Index i = 0; i < n; ++i)
    drift.row(i) = drift_functions((points.col(i) - centre_) / scale_).head(drift.cols()).transpose();
  drift_ = independent_columns(drift);
  const auto d = static_cast<Eigen::Index>(drift_.size());

  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + d, n + d);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      system(i, j) = covariance(kernel.shape, (points_.col(i) - points_.col(j)).norm() / scale_);
  for (Eigen::Index k = 0; k < d; ++k) {
    system.col(n + k).head(n) = drift.col(drift_[static_cast<std::size_t>(k)]);
    system.row(n + k).head(n) = system.col(n + k).head(n).transpose();
  }
  // As many points as drift functions leave nothing to krige: the least-norm solution is the drift's.
  const Eigen::MatrixXd inverse = system.completeOrthogonalDecomposition().pseudoInverse();
  solution_ = inverse.topRows(n);

  const Eigen::MatrixXd precision = inverse.topLeftCorner(n, n);
  const double least = 1e-10 * precision.diagonal().cwiseAbs().maxCoeff();
  leave_one_out_ = Eigen::MatrixXf::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    if (std::abs(precision(i, i)) > least) leave_one_out_.row(i) = (precision.row(i) / precision(i, i)).cast<float>();
}

Eigen::VectorXf PointKriging::weights(const Eigen::Vector3d& point) const {
  const Eigen::Index n = points_.cols();
  Eigen::VectorXd right(solution_.cols());
  Eigen::Vector3d measured = point;
  measured.z() *= kernel_.depth;
  for (Eigen::Index i = 0; i < n; ++i)
    right[i] = covariance(kernel_.shape, (points_.col(i) - measured).norm() / scale_);
  const auto drift = drift_functions((point - centre_) / scale_);
  for (std::size_t k = 0; k < drift_.size(); ++k) right[n + static_cast<Eigen::Index>(k)] = drift[drift_[k]];
  return (solution_ * right).cast<float>();
}

double mean_leave_one_out(const PointKriging& kriging, const Eigen::MatrixXd& gram) {
  const Eigen::MatrixXd errors = kriging.leave_one_out().cast<double>();
  const double sum = (errors * gram).cwiseProduct(errors).sum();
  return std::max(0.0, sum) / static_cast<double>(gram.rows());  // rounded products may leave less than nothing
}

PointKernel choose_kernel(const Eigen::Matrix3Xd& points, const Eigen::MatrixXd& gram,
                          std::span<const PointKernel> kernels) {
  PointKernel best = kernels.front();
  double least = INFINITY;
  for (const PointKernel& kernel : kernels) {
    // Drift that takes all the freedom of the points leaves no error to see: it would win without having shown
    // anything.
    if (2 * kDriftFunctions[static_cast<std::size_t>(kernel.drift_degree)] > points.cols()) continue;
    const double error = mean_leave_one_out(PointKriging(points, kernel), gram);
    if (error < least) {
      least = error;
      best = kernel;
    }
  }
  return best;
}

}  // namespace sheen
