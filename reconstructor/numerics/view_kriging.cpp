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

/// Variance beyond that of the views, in units of the sill, at which half of what the drift says is believed.
constexpr double kHalfBelieved = 0.5;

/// What is left of g, of which kriging is uncertain by g^2 / power: all of it up to `known`.
double believed(double g, double power, double known) {
  const double uncertain = std::max(g * g / power - known, 0.0) / kHalfBelieved;
  return g / (1 + uncertain * uncertain);
}

/// g^2 / power at the view itself where it is largest: there g is what the nugget leaves of the drift, nugget /
/// reliability * (Z f)_j.
template <typename Weights, typename Reliability>
double known_variance(const Weights& drift_weights, const Reliability& reliability, double nugget, double power) {
  double known = 0;
  for (Eigen::Index j = 0; j < drift_weights.size(); ++j) {
    const double g = nugget / static_cast<double>(reliability[j]) * static_cast<double>(drift_weights[j]);
    known = std::max(known, g * g / power);
  }
  return known;
}

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
  Columns columns(m.rows(), kAtOnce), swept(m.rows(), kAtOnce);
  Matrix<Scalar> minus_swept(kAtOnce, whole);
  for (Eigen::Index first = 0; first < whole; first += kAtOnce) {
    columns = m.middleCols(first, kAtOnce);
    const auto pivot = small_inverse<Scalar, kAtOnce>(columns.template middleRows<kAtOnce>(first));
    swept = columns.lazyProduct(pivot);
    minus_swept = -swept.topRows(whole).transpose();
    row_panels::combine<Scalar>(row_panels::columns(columns, kAtOnce), {}, minus_swept, m.rows(),
                                {m.data(), m.rows(), static_cast<int>(whole)}, true);
    m.middleCols(first, kAtOnce) = swept;
    m.middleRows(first, kAtOnce) = -minus_swept;
    m.block(first, first, kAtOnce, kAtOnce) = -pivot;
  }
  return -m.topLeftCorner(n, n);
}

/// Kriging of coefficients Y in matrices: Q is the inverse of the covariance of the views, and Z = Q - Q 1 1^T Q / (1^T
/// Q 1). With a drift f it is projected out as well: Z - Z f f^T Z / (f^T Z f). The weights are Y Z, and the error of
/// view i left out is (Y Z)_i / Z_ii.
template <typename Scalar>
class Kriging {
 public:
  Kriging(const MatrixXf& angles, const Eigen::Ref<const VectorXf>& reliability, const ViewKernel& kernel)
      : reliability_(reliability.template cast<Scalar>()), nugget_(kernel.nugget) {
    Matrix<Scalar> covariance = covariances(kernel, angles).template cast<Scalar>();
    covariance.diagonal() += (kernel.nugget * reliability_.cwiseInverse());
    q_ = inverse(covariance);
    row_sums_ = q_.rowwise().sum();
    total_ = row_sums_.sum();
    diagonal_ = q_.diagonal() - row_sums_.cwiseAbs2() / total_;
  }

  /// Takes the drift into account. False where it says nothing that a constant does not: nothing is done then.
  bool project_out(const VectorXf& drift) {
    const Vector<Scalar> f = drift.template cast<Scalar>();
    const Vector<Scalar> varying = f.array() - f.mean();  // Z takes a constant out, but for what rounding leaves of it
    const Vector<Scalar> zf = q_ * varying - row_sums_ * (row_sums_.dot(varying) / total_);
    const Scalar power = varying.dot(zf);
    if (!(power > kLeastDrift)) return false;
    drift_ = f;
    drift_weights_ = zf;
    drift_power_ = power;
    diagonal_ -= zf.cwiseAbs2() / power;
    return true;
  }

  bool has_drift() const { return drift_.size() > 0; }
  /// Y Z without the drift.
  Matrix<Scalar> ordinary_weights(const Matrix<Scalar>& y) const {
    return y * q_ - (y * row_sums_) * row_sums_.transpose() / total_;
  }
  /// Of the drift: rank; empty without.
  Vector<Scalar> factor(const Matrix<Scalar>& y) const {
    return has_drift() ? Vector<Scalar>(y * drift_weights_ / drift_power_) : Vector<Scalar>();
  }
  /// What Y Z with the drift is less: rank x views.
  Matrix<Scalar> taken_by_drift(const Matrix<Scalar>& y) const { return factor(y) * drift_weights_.transpose(); }
  /// There must be a drift.
  BelievedDrift believed_drift() const {
    const auto power = static_cast<double>(drift_power_);
    return {drift_weights_.template cast<float>(), static_cast<float>(drift_.dot(row_sums_) / total_),
            static_cast<float>(power),
            static_cast<float>(known_variance(drift_weights_, reliability_, nugget_, power))};
  }
  Vector<Scalar> mean(const Matrix<Scalar>& y) const {
    Vector<Scalar> mean = y * row_sums_ / total_;
    if (has_drift()) mean -= factor(y) * (drift_.dot(row_sums_) / total_);
    return mean;
  }

  /// Sum over views of their reliability times the squared error of predicting each from the others, by the weights.
  Scalar leave_one_out(const Matrix<Scalar>& weights) const {
    return (reliability_.array() * weights.colwise().squaredNorm().transpose().array() /
            diagonal_.array().max(kLeastDiagonal).square())
        .sum();
  }
  /// What that is expected to be with a sill of 1: the variance of such a prediction is 1 / Z_ii.
  Scalar expected_leave_one_out() const { return (reliability_.array() / diagonal_.array().max(kLeastDiagonal)).sum(); }

 private:
  // Of a view that alone decides: nothing is left to predict it from, but for what rounding leaves.
  static constexpr Scalar kLeastDiagonal = std::max<Scalar>(Scalar(1e-9), 100 * std::numeric_limits<Scalar>::epsilon());

  Vector<Scalar> reliability_;
  double nugget_;
  Matrix<Scalar> q_;
  Vector<Scalar> diagonal_, row_sums_;
  Scalar total_;
  Vector<Scalar> drift_, drift_weights_;  ///< f and Z f; empty without
  Scalar drift_power_ = 0;                ///< f^T Z f
};

}  // namespace

struct ViewKriging::System {
  Eigen::Index views = 0;
  Kriging<double> kriging;
};

ViewKriging::ViewKriging(const Eigen::Matrix3Xf& directions, const Eigen::Ref<const VectorXf>& reliability,
                         const ViewKernel& kernel, const VectorXf& drift) {
  const Eigen::Index views = directions.cols();
  if (views == 0) return;
  system_ = std::make_unique<System>(System{views, Kriging<double>(angles_between(directions), reliability, kernel)});
  if (views > 2 && drift.size() > 0) system_->kriging.project_out(drift);
}

ViewKriging::ViewKriging(ViewKriging&&) noexcept = default;
ViewKriging::~ViewKriging() = default;

bool ViewKriging::has_drift() const {
  return system_ && system_->kriging.has_drift();
}

BelievedDrift ViewKriging::believed_drift() const {
  return system_->kriging.believed_drift();
}

float BelievedDrift::at(float drift_there, const VectorXf& covariances) const {
  if (weights.size() == 0) return mean;
  const float expected = mean + weights.dot(covariances);
  return expected + static_cast<float>(believed(drift_there - expected, power, known));
}

ViewInterpolant ViewKriging::of(const Eigen::Ref<const MatrixXf>& coefficients) const {
  ViewInterpolant result;
  result.mean = VectorXf::Zero(coefficients.rows());
  result.weights = MatrixXf::Zero(coefficients.rows(), coefficients.cols());
  if (!system_) return result;
  const Kriging<double>& kriging = system_->kriging;
  const MatrixXd y = coefficients.cast<double>();
  result.drift = kriging.factor(y).cast<float>();
  result.mean = kriging.mean(y).cast<float>();
  if (system_->views == 1) return result;
  MatrixXd weights = kriging.ordinary_weights(y);
  if (result.drift.size() > 0) weights -= kriging.taken_by_drift(y);
  result.weights = weights.cast<float>();
  result.leave_one_out = kriging.leave_one_out(weights);
  result.sill = result.leave_one_out / kriging.expected_leave_one_out();
  return result;
}

ViewInterpolant krige(const Eigen::Matrix3Xf& directions, const Eigen::Ref<const MatrixXf>& coefficients,
                      const Eigen::Ref<const VectorXf>& reliability, const ViewKernel& kernel, const VectorXf& drift) {
  return ViewKriging(directions, reliability, kernel, drift).of(coefficients);
}

VectorXf krige_at(const Eigen::Vector3f& direction, float drift_there, const Eigen::Matrix3Xf& directions,
                  const Eigen::Ref<const MatrixXf>& coefficients, const Eigen::Ref<const VectorXf>& reliability,
                  const ViewKernel& kernel, const VectorXf& drift) {
  const Eigen::Index views = directions.cols();
  if (views == 0) return VectorXf::Zero(coefficients.rows());
  const bool drifts = views > 2 && drift.size() > 0;
  MatrixXd covariance = covariances(kernel, angles_between(directions)).cast<double>();
  covariance.diagonal() += kernel.nugget * reliability.cast<double>().cwiseInverse();
  Eigen::Matrix<double, Eigen::Dynamic, 3> sides(views, 3);  // Q k, Q 1 and Q f
  sides << covariances(kernel, directions, direction).cast<double>(), VectorXd::Ones(views), VectorXd::Zero(views);
  const double mean = drifts ? drift.cast<double>().mean() : 0;
  VectorXd varying(drifts ? views : 0);
  if (drifts) sides.col(2) = varying = drift.cast<double>().array() - mean;
  Eigen::LLT<Eigen::Ref<MatrixXd>>(covariance).solveInPlace(sides);
  const auto across = sides.col(0), by_one = sides.col(1), by_drift = sides.col(2);
  VectorXd weights = across + by_one * ((1 - across.sum()) / by_one.sum());
  if (drifts) {
    const VectorXd zf = by_drift - by_one * (by_drift.sum() / by_one.sum());
    const double power = varying.dot(zf);
    if (power > kLeastDrift) {
      const double known = known_variance(zf, reliability, kernel.nugget, power);
      weights += zf * (believed(drift_there - mean - varying.dot(weights), power, known) / power);
    }
  }
  return (coefficients.cast<double>() * weights).cast<float>();
}

template <typename Scalar>
LeaveOneOut leave_one_out(const MatrixXf& angles, const Eigen::Ref<const MatrixXf>& coefficients,
                          const Eigen::Ref<const VectorXf>& reliability, const ViewKernel& kernel,
                          const VectorXf& drift) {
  LeaveOneOut errors;
  errors.with_drift = std::numeric_limits<double>::infinity();
  if (angles.cols() < 2) return errors;
  const Matrix<Scalar> y = coefficients.template cast<Scalar>();
  Kriging<Scalar> kriging(angles, reliability, kernel);
  Matrix<Scalar> weights = kriging.ordinary_weights(y);
  errors.ordinary = kriging.leave_one_out(weights);
  if (angles.cols() >= kFewestViewsWithDrift && drift.size() > 0 && kriging.project_out(drift)) {
    weights -= kriging.taken_by_drift(y);
    errors.with_drift = kriging.leave_one_out(weights);
  }
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
