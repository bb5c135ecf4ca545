// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/folded_views.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "reconstructor/numerics/imputation.h"

namespace sheen {

using Eigen::MatrixXd;
using Eigen::VectorXd;

template <typename Scalar>
double FoldedViews<Scalar>::total_weight() const {
  double weight = 0;
  for (const View& view : views_) weight += view.weight;
  return weight;
}

template <typename Scalar>
VectorXd FoldedViews<Scalar>::weighted_sum() const {
  VectorXd sum = VectorXd::Zero(coefficients_.rows());
  for (int v = 0; v < count(); ++v) sum += views_[v].weight * coefficients_.col(v).template cast<double>();
  return sum;
}

template <typename Scalar>
bool FoldedViews<Scalar>::any_hides_rows() const {
  return std::any_of(views_.begin(), views_.end(), [](const View& view) { return view.shown != nullptr; });
}

template <typename Scalar>
MatrixXd FoldedViews<Scalar>::gram() const {
  const MatrixXd y = coefficients_.template cast<double>();
  VectorXd weight(y.cols());
  for (Eigen::Index v = 0; v < y.cols(); ++v) weight[v] = views_[v].weight;
  MatrixXd gram;
  gram = y * weight.asDiagonal() * y.transpose();  // assigned: Eigen sums in another order where it constructs
  if (scatter_.size() > 0) gram += scatter_;
  return gram;
}

template <typename Scalar>
std::size_t FoldedViews<Scalar>::bytes() const {
  std::size_t bytes =
      sizeof(Scalar) * coefficients_.size() + sizeof(double) * scatter_.size() + sizeof(View) * views_.capacity();
  for (const View& view : views_)
    if (view.shown) bytes += view.shown->bytes();
  return bytes;
}

template <typename Scalar>
void FoldedViews<Scalar>::append(const Fold& fold, std::vector<Arrival> columns) {
  const Eigen::Index before = coefficients_.cols(), more = fold.coordinates.cols();
  coefficients_.conservativeResize(fold.coordinates.rows(), before + more);
  views_.reserve(views_.size() + columns.size());  // no more than that: there are many patches
  for (Eigen::Index j = 0; j < more; ++j) {
    Arrival& column = columns[j];
    coefficients_.col(before + j) = stored<Scalar>(std::ldexp(1.0, column.exponent) * fold.coordinates.col(j));
    views_.push_back({.weight = column.weight,
                      .lost = std::ldexp(std::max(0.0, fold.lost[j]), 2 * column.exponent),
                      .scatter = 0,
                      .unexplained = column.unexplained,
                      .shown = std::move(column.shown)});
  }
}

template <typename Scalar>
void FoldedViews<Scalar>::erase(int view) {
  Scalar* const all = coefficients_.data();
  std::copy(all + (view + 1) * coefficients_.rows(), all + coefficients_.size(), all + view * coefficients_.rows());
  coefficients_.conservativeResize(Eigen::NoChange, coefficients_.cols() - 1);
  views_.erase(views_.begin() + view);
}

template <typename Scalar>
void FoldedViews<Scalar>::follow(const BasisRotation& rotation) {
  if (rotation.kind == BasisRotation::Kind::kNone) return;
  if (rotation.kind == BasisRotation::Kind::kGone) {
    for (int v = 0; v < count(); ++v) views_[v].lost += coefficients_.col(v).template cast<double>().squaredNorm();
    coefficients_.resize(0, count());
    scatter_.resize(0, 0);
    return;
  }
  const MatrixXd& m = rotation.new_from_old;
  Matrix rotated = m.transpose().template cast<Scalar>() * coefficients_;
  for (Eigen::Index v = 0; v < rotated.cols(); ++v)  // in double: coefficients have the scale of their columns
    views_[v].lost += std::max(0.0, coefficients_.col(v).template cast<double>().squaredNorm() -
                                        rotated.col(v).template cast<double>().squaredNorm());
  coefficients_ = std::move(rotated);
  if (scatter_.size() > 0) scatter_ = (m.transpose() * scatter_ * m).eval();
}

template <typename Scalar>
void FoldedViews<Scalar>::multiply(const MatrixXd& factor) {
  coefficients_ = (factor.template cast<Scalar>() * coefficients_).eval();
  if (scatter_.size() > 0) scatter_ = (factor * scatter_ * factor.transpose()).eval();
}

template <typename Scalar>
void FoldedViews<Scalar>::rows_replaced(double share) {
  for (View& view : views_) {
    view.lost *= share;
    view.scatter *= share;
  }
}

template <typename Scalar>
void FoldedViews<Scalar>::merge(int kept, int removed, std::shared_ptr<const Shown> shown) {
  View& a = views_[kept];
  const View& b = views_[removed];
  const double fraction = b.weight / (a.weight + b.weight);
  const Eigen::Matrix<Scalar, Eigen::Dynamic, 1> apart = coefficients_.col(removed) - coefficients_.col(kept);
  const VectorXd d = apart.template cast<double>();
  const double w = a.weight * fraction;
  if (scatter_.size() == 0) scatter_ = MatrixXd::Zero(coefficients_.rows(), coefficients_.rows());
  scatter_.noalias() += w * d * d.transpose();
  a.scatter += b.scatter + w * d.squaredNorm();
  a.lost += fraction * (b.lost - a.lost);
  a.unexplained = a.unexplained < 0 || b.unexplained < 0 ? std::max(a.unexplained, b.unexplained)
                                                         : std::lerp(a.unexplained, b.unexplained, fraction);
  a.weight += b.weight;
  a.shown = std::move(shown);
  coefficients_.col(kept) += static_cast<Scalar>(fraction) * apart;
  erase(removed);
}

template <typename Scalar>
void FoldedViews<Scalar>::remove(int view) {
  const View& gone = views_[view];
  if (gone.scatter > 0) scatter_ *= std::max(0.0, 1 - gone.scatter / std::max(scatter_.trace(), 1e-300));
  erase(view);
}

template <typename Scalar>
void FoldedViews<Scalar>::take_from(int view, const VectorXd& y, double weight, std::shared_ptr<const Shown> shown) {
  View& from = views_[view];
  const double left = from.weight - weight;
  const VectorXd mean = (from.weight * coefficients_.col(view).template cast<double>() - weight * y) / left;
  const VectorXd apart = y - mean;
  const double w = weight * left / from.weight;
  if (scatter_.size() > 0) scatter_.noalias() -= w * apart * apart.transpose();
  from.scatter = std::max(0.0, from.scatter - w * apart.squaredNorm());
  from.weight = left;
  from.shown = std::move(shown);
  coefficients_.col(view) = mean.template cast<Scalar>();
}

template <typename Scalar>
void FoldedViews<Scalar>::improve(int view, const VectorXd& y, double lost) {
  views_[view].lost += lost;
  coefficients_.col(view) = stored<Scalar>(y);
}

template class FoldedViews<float>;
template class FoldedViews<double>;

}  // namespace sheen
