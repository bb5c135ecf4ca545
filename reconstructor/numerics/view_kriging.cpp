// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/view_kriging.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "reconstructor/numerics/row_panels.h"

namespace sheen {
namespace {

using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::VectorXd;
using Eigen::VectorXf;

/// A drift that the views hardly tell from a constant cannot be fitted.
constexpr float kLeastDrift = 1e-6;

template <typename Scalar>
using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
template <typename Scalar>
using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

/// Inverse of a small positive definite matrix: rows and columns are exchanged for their own one after the other.
template <typename Scalar, int Size>
Eigen::Matrix<Scalar, Size, Size> small_inverse(Eigen::Matrix<Scalar, Size, Size> m) {
  for (int k = 0; k < Size; ++k) {
    const Eigen::Matrix<Scalar, Size, 1> column = m.col(k), swept = column / column[k];
    m.noalias() -= swept * column.transpose();
    m.col(k) = swept;
    m.row(k) = swept.transpose();
    m(k, k) = -1 / column[k];
  }
  return -m;
}

/// The same for some tens of rows, a few at a time: quicker than a factorization.
template <typename Scalar>
Matrix<Scalar> inverse(const Matrix<Scalar>& positive) {
  constexpr int kAtOnce = 8;
  using Columns = Eigen::Matrix<Scalar, Eigen::Dynamic, kAtOnce>;
  const Eigen::Index n = positive.cols(), whole = (n + kAtOnce - 1) / kAtOnce * kAtOnce;
  Matrix<Scalar> m = Matrix<Scalar>::Identity(row_panels::padded(n), whole);  // what is added is its own inverse
  m.topLeftCorner(n, n) = positive;
  for (Eigen::Index first = 0; first < whole; first += kAtOnce) {
    const Columns columns = m.middleCols(first, kAtOnce);
    const auto pivot = small_inverse<Scalar, kAtOnce>(columns.template middleRows<kAtOnce>(first));
    const Columns swept = columns.lazyProduct(pivot);
    const Matrix<Scalar> minus_swept = -swept.topRows(whole).transpose();
    row_panels::combine<Scalar>(row_panels::columns(columns, kAtOnce), {}, minus_swept, m.rows(),
                                {m.data(), m.rows(), static_cast<int>(whole)}, true);
    m.middleCols(first, kAtOnce) = swept;
    m.middleRows(first, kAtOnce) = -minus_swept;
    m.block(first, first, kAtOnce, kAtOnce) = -pivot;
  }
  return -m.topLeftCorner(n, n);
}

/// Kriging in matrices: Q is the inverse of the covariance of the views, and Z = Q - Q 1 1^T Q / (1^T Q 1). With a
/// drift f it is projected out as well: Z - Z f f^T Z / (f^T Z f). The error of view i left out is (Y Z)_i / Z_ii.
template <typename Scalar>
class Kriging {
 public:
  Kriging(const MatrixXf& angles, const Eigen::Ref<const MatrixXf>& coefficients,
          const Eigen::Ref<const VectorXf>& reliability, const ViewKernel& kernel)
      : y_(coefficients.template cast<Scalar>()), reliability_(reliability.template cast<Scalar>()) {
    Matrix<Scalar> covariance = covariances(kernel, angles).template cast<Scalar>();
    covariance.diagonal() += (kernel.nugget * reliability_.cwiseInverse());
    q_ = inverse(covariance);
    row_sums_ = q_.rowwise().sum();
    total_ = row_sums_.sum();
    diagonal_ = q_.diagonal() - row_sums_.cwiseAbs2() / total_;
    weights_ = y_ * q_ - (y_ * row_sums_) * row_sums_.transpose() / total_;
  }

  /// Takes the drift into account. False where it says nothing that a constant does not: nothing is done then.
  bool project_out(const VectorXf& drift) {
    const Vector<Scalar> f = drift.template cast<Scalar>();
    const Vector<Scalar> varying = f.array() - f.mean();  // Z takes a constant out, but for what rounding leaves of it
    const Vector<Scalar> zf = q_ * varying - row_sums_ * (row_sums_.dot(varying) / total_);
    const Scalar power = varying.dot(zf);
    if (!(power > kLeastDrift)) return false;
    factor_ = y_ * zf / power;
    weights_ -= factor_ * zf.transpose();
    diagonal_ -= zf.cwiseAbs2() / power;
    y_ -= factor_ * f.transpose();
    return true;
  }

  const Vector<Scalar>& factor() const { return factor_; }    ///< of the drift: rank; empty without
  const Matrix<Scalar>& weights() const { return weights_; }  ///< Y Z: rank x views
  Vector<Scalar> mean() const { return y_ * row_sums_ / total_; }

  /// Sum over views of their reliability times the squared error of predicting each from the others.
  Scalar leave_one_out() const {
    return (reliability_.array() * weights_.colwise().squaredNorm().transpose().array() /
            diagonal_.array().max(kLeastDiagonal).square())
        .sum();
  }
  /// That over its expectation with a sill of 1: the variance of such a prediction is 1 / Z_ii.
  Scalar sill() const { return leave_one_out() / (reliability_.array() / diagonal_.array().max(kLeastDiagonal)).sum(); }

 private:
  // Of a view that alone decides: nothing is left to predict it from, but for what rounding leaves.
  static constexpr Scalar kLeastDiagonal = std::max<Scalar>(Scalar(1e-9), 100 * std::numeric_limits<Scalar>::epsilon());

  Matrix<Scalar> y_;
  Vector<Scalar> reliability_;
  Matrix<Scalar> q_;
  Vector<Scalar> diagonal_, row_sums_, factor_;
  Scalar total_;
  Matrix<Scalar> weights_;
};

}  // namespace

ViewInterpolant krige(const Eigen::Matrix3Xf& directions, const Eigen::Ref<const MatrixXf>& coefficients,
                      const Eigen::Ref<const VectorXf>& reliability, const ViewKernel& kernel, const VectorXf& drift) {
  const Eigen::Index n = directions.cols();
  ViewInterpolant result;
  result.mean = VectorXf::Zero(coefficients.rows());
  result.weights = MatrixXf::Zero(coefficients.rows(), n);
  if (n == 0) return result;

  Kriging<double> kriging(angles_between(directions), coefficients, reliability, kernel);
  if (n > 2 && drift.size() > 0 && kriging.project_out(drift)) result.drift = kriging.factor().cast<float>();
  result.mean = kriging.mean().cast<float>();
  if (n == 1) return result;
  result.weights = kriging.weights().cast<float>();
  result.leave_one_out = kriging.leave_one_out();
  result.sill = kriging.sill();
  return result;
}

template <typename Scalar>
LeaveOneOut leave_one_out(const MatrixXf& angles, const Eigen::Ref<const MatrixXf>& coefficients,
                          const Eigen::Ref<const VectorXf>& reliability, const ViewKernel& kernel,
                          const VectorXf& drift) {
  LeaveOneOut errors;
  errors.with_drift = std::numeric_limits<double>::infinity();
  if (angles.cols() < 2) return errors;
  Kriging<Scalar> kriging(angles, coefficients, reliability, kernel);
  errors.ordinary = kriging.leave_one_out();
  if (angles.cols() >= kFewestViewsWithDrift && drift.size() > 0 && kriging.project_out(drift))
    errors.with_drift = kriging.leave_one_out();
  return errors;
}

template LeaveOneOut leave_one_out<float>(const MatrixXf&, const Eigen::Ref<const MatrixXf>&,
                                          const Eigen::Ref<const VectorXf>&, const ViewKernel&, const VectorXf&);
template LeaveOneOut leave_one_out<double>(const MatrixXf&, const Eigen::Ref<const MatrixXf>&,
                                           const Eigen::Ref<const VectorXf>&, const ViewKernel&, const VectorXf&);

float prediction_variance(const Eigen::Matrix3Xf& directions, const ViewKernel& kernel,
                          const Eigen::Vector3f& direction) {
  constexpr Eigen::Index kMostNearest = 6;
  constexpr float kLeastNugget = 1e-6f;  // views may coincide
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostNearest, kMostNearest>;
  using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostNearest, 1>;
  const VectorXf cosines = directions.transpose() * direction;
  const Eigen::Index n = std::min(kMostNearest, directions.cols());
  std::vector<Eigen::Index> nearest(static_cast<std::size_t>(directions.cols()));
  std::iota(nearest.begin(), nearest.end(), Eigen::Index{0});
  std::partial_sort(nearest.begin(), nearest.begin() + n, nearest.end(),
                    [&](Eigen::Index a, Eigen::Index b) { return cosines[a] > cosines[b]; });
  Small among(n, n);
  SmallVector across(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3f view = directions.col(nearest[static_cast<std::size_t>(i)]);
    across[i] = evaluate(kernel, angle_between(view, direction));
    for (Eigen::Index j = 0; j <= i; ++j)
      among(i, j) = evaluate(kernel, angle_between(view, directions.col(nearest[static_cast<std::size_t>(j)])));
    among(i, i) += std::max(kernel.nugget, kLeastNugget);
  }
  const Eigen::LLT<Small> factor(among);
  const SmallVector one = SmallVector::Ones(n), by_one = factor.solve(one), by_across = factor.solve(across);
  const double missed = 1 - by_across.sum();
  return static_cast<float>(1 + kernel.nugget - across.dot(by_across) + missed * missed / by_one.sum());
}

VectorXf interpolate(const ViewInterpolant& interpolant, const Eigen::Matrix3Xf& directions, const ViewKernel& kernel,
                     const Eigen::Vector3f& direction) {
  return interpolant.mean + interpolant.weights * covariances(kernel, directions, direction);
}

}  // namespace sheen
