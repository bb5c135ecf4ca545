// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/ring_factor.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace sheen {
namespace {

constexpr double kEpsilon = std::numeric_limits<float>::epsilon();
// Below this share of the column's norm the residual is rounding noise and no direction.
constexpr double kNoise = 50 * kEpsilon;
// "Twice is enough": when the projection cancelled this much, the residual is orthogonalised once more.
constexpr double kSecondPass = 0.7;

double norm_of(const Eigen::Ref<const Eigen::VectorXf>& v) {
  return std::sqrt(v.cast<double>().squaredNorm());
}

}  // namespace

ColumnReport RingFactor::add(const Eigen::Ref<const Eigen::VectorXf>& column, double weight) {
  ColumnReport report;
  report.norm = norm_of(column);

  Eigen::VectorXf y = basis().transpose() * column;  // j = U^T c
  Eigen::VectorXf p = column - basis() * y;          // p = c - U j
  report.residual_norm = norm_of(p);
  if (rank_ > 0 && report.residual_norm < kSecondPass * report.norm) {
    const Eigen::VectorXf correction = basis().transpose() * p;
    y += correction;
    p.noalias() -= basis() * correction;
    report.residual_norm = norm_of(p);
  }

  const double column_energy = weight * report.norm * report.norm;
  const double residual_energy = weight * report.residual_norm * report.residual_norm;
  energy_ += column_energy;
  weight_sum_ += weight;
  const double budget = options_.tolerance * options_.tolerance * energy_;
  report.grew = report.residual_norm > kNoise * report.norm && lost_ + residual_energy > budget && rank_ < rows_;

  reserve_views(views_ + 1);
  if (report.grew) {
    reserve_rank(rank_ + 1);
    basis_.col(rank_) = p * static_cast<float>(1 / report.residual_norm);  // Brand appends p / ||p||
    coefficients_.row(rank_).head(views_).setZero();
    gram_.conservativeResize(rank_ + 1, rank_ + 1);
    gram_.row(rank_).setZero();
    gram_.col(rank_).setZero();
    ++rank_;
    ++appended_;
    y.conservativeResize(rank_);
    y[rank_ - 1] = static_cast<float>(report.residual_norm);
  } else {
    lost_ += residual_energy;
  }
  coefficients_.col(views_).head(rank_) = y;
  ++views_;
  ++columns_added_;
  const Eigen::VectorXd yd = y.cast<double>();
  gram_.noalias() += weight * yd * yd.transpose();

  if (appended_ >= options_.block) compress();
  return report;
}

void RingFactor::compress() {
  appended_ = 0;
  if (rank_ == 0) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram_);  // ascending
  const double budget = options_.tolerance * options_.tolerance * energy_;
  int dropped = 0;
  double tail = 0;
  while (dropped < rank_) {
    const double next = std::max(0.0, eigen.eigenvalues()[dropped]);
    const bool affordable = lost_ + tail + next <= budget;
    const bool rounding = next <= kNoise * kNoise * energy_;
    if (!affordable && !rounding && rank_ - dropped <= options_.max_rank) break;
    tail += next;
    ++dropped;
  }
  const int kept = rank_ - dropped;
  lost_ += tail;

  const Eigen::MatrixXd rotation = eigen.eigenvectors().rightCols(kept).rowwise().reverse();
  // One Newton step towards the nearest orthonormal basis, folded into the rotation: what rounding took from B^T B = I
  // is given back at every compression.
  const Eigen::MatrixXf overlap = basis().transpose() * basis();
  const Eigen::MatrixXd polish = 1.5 * Eigen::MatrixXd::Identity(rank_, rank_) - 0.5 * overlap.cast<double>();
  const Eigen::MatrixXf turn = (polish * rotation).cast<float>();
  const Eigen::MatrixXf turned = basis() * turn;
  const Eigen::MatrixXf turned_coefficients = rotation.cast<float>().transpose() * coefficients();
  rank_ = kept;
  basis_.leftCols(kept) = turned;
  coefficients_.topLeftCorner(kept, views_) = turned_coefficients;
  gram_ = eigen.eigenvalues().tail(kept).reverse().cwiseMax(0).asDiagonal();
}

Eigen::VectorXf RingFactor::estimate(const Eigen::Ref<const Eigen::VectorXf>& column,
                                     std::span<const std::uint8_t> known, double noise) const {
  if (rank_ == 0) return {};
  std::vector<int> rows;
  rows.reserve(known.size());
  for (std::size_t i = 0; i < known.size(); ++i)
    if (known[i]) rows.push_back(static_cast<int>(i));
  const Eigen::MatrixXf known_basis = basis()(rows, Eigen::all);
  const Eigen::VectorXf known_values = column(rows);
  Eigen::MatrixXd normal = (known_basis.transpose() * known_basis).cast<double>();
  const Eigen::VectorXd right = (known_basis.transpose() * known_values).cast<double>();
  // Prior covariance G / n; a floor keeps directions that have hardly been used invertible.
  Eigen::MatrixXd prior = gram_ / std::max(weight_sum_, 1e-300);
  const double floor = std::max(1e-6 * prior.trace() / rank_, 1e-300);
  prior.diagonal().array() += floor;
  const Eigen::MatrixXd precision = prior.llt().solve(Eigen::MatrixXd::Identity(rank_, rank_));
  normal += std::max(noise, 0.0) * precision;
  normal.diagonal().array() += 1e-9 * std::max(normal.trace() / rank_, 1e-300);
  const Eigen::VectorXd y = normal.ldlt().solve(right);
  return y.allFinite() ? Eigen::VectorXf(y.cast<float>()) : Eigen::VectorXf::Zero(rank_);
}

void RingFactor::reveal(std::span<const int> rows, const Eigen::MatrixXf& rows_of_basis) {
  if (rows.empty() || rank_ == 0) return;
  for (std::size_t i = 0; i < rows.size(); ++i) basis_.row(rows[i]).head(rank_) = rows_of_basis.row(i);
  energy_ += (rows_of_basis.cast<double>() * gram_).cwiseProduct(rows_of_basis.cast<double>()).sum();
  // B was orthonormal before: only the new rows' overlap R^T R has to be undone, by B <- B R^-1, Y <- R Y.
  const Eigen::MatrixXd overlap = (basis().transpose() * basis()).cast<double>();
  const Eigen::LLT<Eigen::MatrixXd> cholesky(overlap);
  if (cholesky.info() != Eigen::Success) return;
  const Eigen::MatrixXd r = cholesky.matrixU();
  const Eigen::MatrixXd inverse = cholesky.matrixU().solve(Eigen::MatrixXd::Identity(rank_, rank_));
  const Eigen::MatrixXf turned = basis() * inverse.cast<float>();
  const Eigen::MatrixXf turned_coefficients = r.cast<float>() * coefficients();
  basis_.leftCols(rank_) = turned;
  coefficients_.topLeftCorner(rank_, views_) = turned_coefficients;
  gram_ = (r * gram_ * r.transpose()).eval();
}

void RingFactor::merge_views(int kept, int removed, double kept_share) {
  const auto share = static_cast<float>(kept_share);
  coefficients_.col(kept).head(rank_) =
      share * coefficients_.col(kept).head(rank_) + (1 - share) * coefficients_.col(removed).head(rank_);
  coefficients_.col(removed).head(rank_) = coefficients_.col(views_ - 1).head(rank_);
  --views_;
}

std::size_t RingFactor::bytes() const {
  return sizeof(float) * (basis_.size() + coefficients_.size()) + sizeof(double) * gram_.size();
}

void RingFactor::reserve_rank(int rank) {
  if (rank <= basis_.cols()) return;
  const int capacity = std::min(std::max(rank, rank_ + 4), options_.max_rank + options_.block);
  basis_.conservativeResize(rows_, std::max(capacity, rank));
  coefficients_.conservativeResize(std::max(capacity, rank), coefficients_.cols());
}

void RingFactor::reserve_views(int views) {
  if (views <= coefficients_.cols()) return;
  coefficients_.conservativeResize(std::max<Eigen::Index>(coefficients_.rows(), 1), std::max(views, 2 * views_));
}

}  // namespace sheen
