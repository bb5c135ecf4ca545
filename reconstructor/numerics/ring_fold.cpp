// SPDX-License-Identifier: Apache-2.0
// How a block of columns joins the online SVD; the class is in ring_factor.h.
#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "reconstructor/numerics/imputation.h"
#include "reconstructor/numerics/orthonormal.h"
#include "reconstructor/numerics/ring_factor.h"
#include "reconstructor/numerics/row_panels.h"
#include "reconstructor/numerics/symmetric_eigen.h"

namespace sheen {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using row_panels::columns;

// Below this share of a column's norm its residual is rounding noise and no direction.
template <typename Scalar>
constexpr double kNoise = 50 * std::numeric_limits<Scalar>::epsilon();
// A residual that the others of its block explain but for this share of its energy gives no direction of its own:
// inner products are not more exact than that.
template <typename Scalar>
constexpr double kSmallestPivot = 16 * std::numeric_limits<Scalar>::epsilon();
// Rounding in the Gram matrix of the residuals reaches the basis magnified by this much at most; beyond it, they are
// orthogonalised once more. "Twice is enough" where the first time leaves a correct digit; where it leaves rounding
// alone, as of residuals that lie in the basis but for the last digits, the third time is.
constexpr double kLargestGrowth = 1.5;
constexpr int kMostPasses = 3;

// A turn of the basis costs it about one unit of rounding of orthonormality, and a polish gives it back.
constexpr int kTurnsBetweenPolishes = 4;
// What is dropped on the way may be missed later: it takes this share of the budget, the displayed rank the whole.
constexpr double kShareOfBudgetOnTheWay = 0.5;

}  // namespace

/// Core coordinates are those of Q = [B' R]: the polished basis B' = B (I - E/2) and the orthonormalised residuals
/// R = (P - B overlap) to_directions.
template <typename Scalar>
struct BasicRingFactor<Scalar>::Block {
  int count = 0;
  VectorXd weight;            ///< a column; of the buffered column, which is scaled by a power of two
  VectorXd norm2, residual2;  ///< ||c||^2, ||p||^2 of the buffered column
  double lost = 0;            ///< energy that neither basis nor directions hold
  MatrixXd inside;            ///< rank x count: coefficients in B
  MatrixXd outside;           ///< directions x count: coefficients in R
  MatrixXd overlap;           ///< rank x count: B^T P, what projecting once left behind
  MatrixXd to_directions;     ///< count x directions
  MatrixXd loss;              ///< E = B^T B - I; empty when the basis will not turn
  std::vector<std::shared_ptr<const Shown>> shown;  ///< a column
};

/// New basis = Q from_core: the leading singular directions of all columns, in core coordinates.
template <typename Scalar>
struct BasicRingFactor<Scalar>::Turn {
  int rank = 0, displayed = 0;
  double lost = 0;       ///< energy of the directions left out
  VectorXd spectrum;     ///< rank
  MatrixXd from_core;    ///< core size x rank
  MatrixXd core;         ///< G of all columns, the block's included
  MatrixXd coordinates;  ///< core size x count: of the block's columns
};

template <typename Scalar>
typename BasicRingFactor<Scalar>::Reports BasicRingFactor<Scalar>::fold() {
  Reports reports;
  if (pending_.empty()) return reports;
  impute_again_when_due();
  Block block;
  block.count = pending();
  block.weight.resize(block.count);
  for (int j = 0; j < block.count; ++j) {
    block.weight[j] = std::ldexp(pending_[j].weight, 2 * pending_[j].exponent);
    block.shown.push_back(shown_by(j));
  }
  const std::vector<std::uint64_t> hidden = hidden_patterns();
  if (unseen_rows_ > 0) reveal_rows({block.weight.data(), static_cast<std::size_t>(block.count)}, hidden);

  // y = B^T c, p = c - B y (000 sec. 3.1), with the hidden rows of c at their most probable values B y: p is 0 there.
  block.norm2 = row_panels::squared_norms(columns(buffer_, block.count), buffer_.rows());
  const Matrix y = pending_projections(hidden).template cast<Scalar>();
  block.inside = y.template cast<double>();
  if (rank_ > 0)
    row_panels::combine<Scalar>(columns(basis_, rank_), {}, -y, basis_.rows(),
                                {buffer_.data(), buffer_.rows(), block.count}, true);
  for (std::size_t row = 0; row < hidden.size(); ++row)
    for (std::uint64_t bits = hidden[row]; bits != 0; bits &= bits - 1)
      buffer_(static_cast<Eigen::Index>(row), std::countr_zero(bits)) = 0;

  reports = split_residuals(block);
  absorb(block);
  columns_folded_ += block.count;
  pending_.clear();
  return reports;
}

/// Separates what the basis does not hold of the block, and orthonormalises it where it may not be lost.
template <typename Scalar>
typename BasicRingFactor<Scalar>::Reports BasicRingFactor<Scalar>::split_residuals(Block& block) {
  const int count = block.count;
  Reports reports(count);
  block.overlap = row_panels::inner_products(columns(basis_, rank_), columns(buffer_, count), buffer_.rows());
  block.inside += block.overlap;
  const VectorXd norm2 = row_panels::squared_norms(columns(buffer_, count), buffer_.rows());
  block.residual2 = norm2;
  double energy_after = energy();
  for (int j = 0; j < count; ++j) {
    double& residual2 = block.residual2[j];
    residual2 = std::max(0.0, residual2 - block.overlap.col(j).squaredNorm());
    if (residual2 <= kNoise<Scalar> * kNoise<Scalar> * block.norm2[j]) residual2 = 0;
    block.lost += block.weight[j] * residual2;
    energy_after += block.weight[j] * (residual2 + block.inside.col(j).squaredNorm());
    reports[j] = report(pending_[j], block.norm2[j], residual2);
  }
  block.outside = MatrixXd::Zero(0, count);
  block.to_directions = MatrixXd::Zero(count, 0);
  if (lost_ + block.lost <= kShareOfBudgetOnTheWay * options_.tolerance * options_.tolerance * energy_after)
    return reports;
  MatrixXd gram = row_panels::gram(columns(buffer_, count), buffer_.rows(), norm2);
  gram.noalias() -= block.overlap.transpose() * block.overlap;
  Orthonormalised residuals = orthonormalise(std::move(gram), block.residual2, kSmallestPivot<Scalar>);
  block.to_directions = std::move(residuals.to_directions);
  block.outside = std::move(residuals.coefficients);
  block.lost = 0;
  for (int j = 0; j < count; ++j)
    block.lost += block.weight[j] * std::max(0.0, block.residual2[j] - block.outside.col(j).squaredNorm());
  return reports;
}

/// What a column brought, which `row_noise` follows.
template <typename Scalar>
ColumnReport BasicRingFactor<Scalar>::report(const Pending& column, double norm2, double residual2) {
  ColumnReport report;
  report.norm = std::ldexp(std::sqrt(norm2), column.exponent);
  report.residual_norm = std::ldexp(std::sqrt(residual2), column.exponent);
  report.known_rows = column.known_rows(rows_);
  report.first = rank_ == 0 || column.guessed;
  if (report.first || report.known_rows == 0) return report;
  const double variance = report.residual_norm * report.residual_norm / report.known_rows;
  row_noise_ = columns_predicted_ == 0 ? variance : std::lerp(variance, row_noise_, options_.residual_memory);
  ++columns_predicted_;
  return report;
}

/// How many terms to keep and how many of them to display. `descending`: squared singular values; `lost`: energy
/// without any direction.
template <typename Scalar>
void BasicRingFactor<Scalar>::choose_rank(const VectorXd& descending, double lost, Turn& turn) const {
  const double energy = lost + descending.sum();
  const double budget = options_.tolerance * options_.tolerance * energy;
  // of the columns, and of the eigenvalues, which are no more exact than the largest of them
  const double rounding =
      std::max(kNoise<Scalar> * kNoise<Scalar>, 4 * std::numeric_limits<double>::epsilon()) * energy;
  turn.rank = static_cast<int>(descending.size());
  while (turn.rank > 0) {
    const double next = descending[turn.rank - 1];
    const bool affordable = lost + turn.lost + next <= kShareOfBudgetOnTheWay * budget;
    if (!affordable && next > rounding && turn.rank <= options_.terms_kept()) break;
    turn.lost += next;
    --turn.rank;
  }
  turn.displayed = turn.rank;
  for (double hidden = lost + turn.lost; turn.displayed > 0; --turn.displayed) {
    hidden += descending[turn.displayed - 1];
    if (hidden > budget && turn.displayed <= options_.max_rank) break;
  }
}

/// Orthonormalises the directions of the block once more, now as columns of their own, whose squared norms it returns.
template <typename Scalar>
VectorXd BasicRingFactor<Scalar>::orthonormalise_again(Block& block) {
  const auto columns_before = static_cast<int>(block.to_directions.rows());
  const auto directions = static_cast<int>(block.to_directions.cols());
  Matrix m(rank_ + columns_before, directions);
  m << (-block.overlap * block.to_directions).template cast<Scalar>(), block.to_directions.template cast<Scalar>();
  row_panels::combine<Scalar>(columns(basis_, rank_), columns(buffer_, columns_before), m, buffer_.rows(),
                              {buffer_.data(), buffer_.rows(), directions});
  const auto residuals = columns(buffer_, directions);
  block.overlap = row_panels::inner_products(columns(basis_, rank_), residuals, buffer_.rows());
  MatrixXd gram = row_panels::gram(residuals, buffer_.rows());
  VectorXd norm2 = gram.diagonal();
  gram.noalias() -= block.overlap.transpose() * block.overlap;
  const Orthonormalised once_more = orthonormalise(gram, gram.diagonal().cwiseMax(0), kSmallestPivot<Scalar>);
  block.to_directions = once_more.to_directions;
  block.inside += block.overlap * block.outside;
  block.outside = once_more.coefficients * block.outside;
  return norm2;
}

template <typename Scalar>
typename BasicRingFactor<Scalar>::Turn BasicRingFactor<Scalar>::singular_turn(const Block& block) const {
  const Eigen::Index directions = block.outside.rows(), size = rank_ + directions;
  if (size == 0) return {.coordinates = MatrixXd::Zero(0, block.count)};
  MatrixXd z(size, block.count);
  if (block.count > 0) {
    z.topRows(rank_) = block.inside;
    z.bottomRows(directions) = block.outside;
    if (block.loss.size() > 0) z.topRows(rank_) += 0.5 * block.loss * block.inside;  // in the polished basis
  }
  // G holds what was meant: E is what rounding did to B since, mostly with one sign, and would wear G down fold by
  // fold.
  MatrixXd core = MatrixXd::Zero(size, size);
  core.topLeftCorner(rank_, rank_) = gram_;
  core.noalias() += z * block.weight.asDiagonal() * z.transpose();

  Turn turn;
  const SymmetricEigen eigen = symmetric_eigen(core);
  turn.spectrum = eigen.values.cwiseMax(0);
  choose_rank(turn.spectrum, lost_ + block.lost, turn);
  turn.spectrum.conservativeResize(turn.rank);
  turn.coordinates = std::move(z);
  turn.core = std::move(core);
  turn.from_core = eigen.vectors.leftCols(turn.rank);
  return turn;
}

/// What rounding in the inner products of the residuals, times their norms, is magnified by on its way to the basis.
template <typename Scalar>
double BasicRingFactor<Scalar>::growth(const Block& block, const VectorXd& norm2, const Turn& turn) const {
  if (turn.rank == 0) return 0;
  const MatrixXd reach =
      norm2.cwiseSqrt().asDiagonal() * block.to_directions * turn.from_core.bottomRows(block.outside.rows());
  return reach.colwise().squaredNorm().maxCoeff();
}

/// Adds the block to Y and G, and turns the basis to the new singular directions.
template <typename Scalar>
void BasicRingFactor<Scalar>::absorb(Block& block) {
  const bool grows = block.outside.rows() > 0;
  const auto polish = [&] {
    block.loss = row_panels::gram(columns(basis_, rank_), basis_.rows());
    block.loss.diagonal().array() -= 1;
  };
  const bool turns = grows || rank_ > displayed_ || block.count == 0;
  if (turns && turns_++ % kTurnsBetweenPolishes == 0) polish();
  Turn turn = singular_turn(block);
  if (!turns && turn.displayed == rank_) {  // nothing new: the basis stays as it is
    gram_ = turn.core;
    spectrum_ = turn.spectrum;
    lost_ += block.lost;
    append_views(block, turn.coordinates);
    return;
  }
  if (grows) {
    // Those of columns with hidden rows may lie mostly within B.
    VectorXd norm2 = block.residual2 + block.overlap.colwise().squaredNorm().transpose();
    for (int pass = 1; pass < kMostPasses && growth(block, norm2, turn) > kLargestGrowth; ++pass) {
      norm2 = orthonormalise_again(block);
      turn = singular_turn(block);
    }
  }
  apply(turn, block);
}

/// Nothing is left but zeros, or less than the tolerance.
template <typename Scalar>
void BasicRingFactor<Scalar>::forget_directions(const Turn& turn, const Block& block) {
  for (int v = 0; v < folded_views(); ++v)
    if (rank_ > 0) views_[v].lost += coefficients_.col(v).template cast<double>().squaredNorm();
  basis_.resize(row_panels::padded(rows_), 0);
  coefficients_.resize(0, folded_views());
  gram_.resize(0, 0);
  scatter_.resize(0, 0);
  spectrum_.resize(0);
  lost_ += block.lost + turn.lost;
  rank_ = displayed_ = 0;
  append_views(block, MatrixXd::Zero(0, block.count));
}

template <typename Scalar>
void BasicRingFactor<Scalar>::apply(Turn& turn, const Block& block) {
  if (turn.rank == 0) return forget_directions(turn, block);
  const Eigen::Index directions = block.outside.rows();
  const Eigen::Index displayed = turn.displayed;
  const MatrixXd rotation = aligning_rotation(turn.from_core.leftCols(displayed), displayed_rank());
  turn.from_core.leftCols(displayed) = (turn.from_core.leftCols(displayed) * rotation).eval();

  const MatrixXd from_basis = turn.from_core.topRows(rank_);
  MatrixXd half = MatrixXd::Zero(rank_, turn.rank);  // E/2 of it
  if (block.loss.size() > 0) half = 0.5 * block.loss * from_basis;
  const MatrixXd from_residuals = block.to_directions * turn.from_core.bottomRows(directions);
  Matrix m(rank_ + from_residuals.rows(), turn.rank);
  m.topRows(rank_) = (from_basis - half - block.overlap * from_residuals).template cast<Scalar>();
  m.bottomRows(from_residuals.rows()) = from_residuals.template cast<Scalar>();
  const auto residuals = static_cast<int>(from_residuals.rows());
  const Eigen::Index padded = row_panels::padded(rows_);
  if (turn.rank == basis_.cols()) {
    row_panels::combine<Scalar>(columns(basis_, rank_), columns(buffer_, residuals), m, padded,
                                {basis_.data(), padded, turn.rank});
  } else {
    Matrix turned(padded, turn.rank);
    row_panels::combine<Scalar>(columns(basis_, rank_), columns(buffer_, residuals), m, padded,
                                {turned.data(), padded, turn.rank});
    basis_ = std::move(turned);
  }

  Matrix turned = (from_basis + half).transpose().template cast<Scalar>() * coefficients_;
  for (Eigen::Index v = 0; v < turned.cols(); ++v)  // in double: coefficients have the scale of their columns
    views_[v].lost += std::max(0.0, coefficients_.col(v).template cast<double>().squaredNorm() -
                                        turned.col(v).template cast<double>().squaredNorm());
  coefficients_ = std::move(turned);
  if (scatter_.size() > 0) scatter_ = ((from_basis + half).transpose() * scatter_ * (from_basis + half)).eval();
  gram_ = turn.spectrum.asDiagonal();
  gram_.topLeftCorner(displayed, displayed) =
      rotation.transpose() * turn.spectrum.head(displayed).asDiagonal() * rotation;
  spectrum_ = turn.spectrum;
  lost_ += block.lost + turn.lost;
  rank_ = turn.rank;
  displayed_ = turn.displayed;
  append_views(block, turn.from_core.transpose() * turn.coordinates);
}

/// `coordinates`: of the block's columns in the basis as it now is.
template <typename Scalar>
void BasicRingFactor<Scalar>::append_views(const Block& block, const MatrixXd& coordinates) {
  const Eigen::Index before = coefficients_.cols();
  coefficients_.conservativeResize(rank_, before + block.count);
  views_.reserve(views_.size() + static_cast<std::size_t>(block.count));  // no more than that: there are many rings
  for (int j = 0; j < block.count; ++j) {
    const int exponent = pending_[j].exponent;
    coefficients_.col(before + j) = stored<Scalar>(std::ldexp(1.0, exponent) * coordinates.col(j));
    const double inside = (block.inside.col(j).squaredNorm() + block.residual2[j]) - coordinates.col(j).squaredNorm();
    views_.push_back({.weight = pending_[j].weight,
                      .lost = std::ldexp(std::max(0.0, inside), 2 * exponent),
                      .scatter = 0,
                      .shown = std::move(block.shown[j])});
  }
}

template <typename Scalar>
void BasicRingFactor<Scalar>::turn_to_singular_order() {
  if (rank_ == 0) return;
  Block nothing;
  nothing.inside = nothing.overlap = MatrixXd::Zero(rank_, 0);
  nothing.outside = nothing.to_directions = MatrixXd::Zero(0, 0);
  absorb(nothing);
}

// The members that ring_factor.cpp uses; they bring the others with them.
template BasicRingFactor<float>::Reports BasicRingFactor<float>::fold();
template BasicRingFactor<double>::Reports BasicRingFactor<double>::fold();
template void BasicRingFactor<float>::turn_to_singular_order();
template void BasicRingFactor<double>::turn_to_singular_order();

}  // namespace sheen
