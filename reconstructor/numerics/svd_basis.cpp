// SPDX-License-Identifier: Apache-2.0
// The numbers in brackets are those of the equations in svd_basis.h.
#include "reconstructor/numerics/svd_basis.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "reconstructor/numerics/fixed_point.h"
#include "reconstructor/numerics/orthonormal.h"
#include "reconstructor/numerics/symmetric_eigen.h"

namespace sheen {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Below this fraction of a column's norm its residual is rounding noise and no direction.
template <typename Scalar>
constexpr double kNoise = 50 * std::numeric_limits<Scalar>::epsilon();
// A residual that the others of its block explain but for this fraction of its energy gives no direction of its own:
// inner products are not more exact than that.
template <typename Scalar>
constexpr double kSmallestPivot = 16 * std::numeric_limits<Scalar>::epsilon();
// Rounding in the Gram matrix of the residuals reaches the basis magnified by this much at most; beyond it, they are
// orthogonalised once more. "Twice is enough" where the first time leaves a correct digit; where it leaves rounding
// alone, as of residuals that lie in the basis but for the last digits, the third time is.
constexpr double kLargestGrowth = 1.5;
constexpr int kMostPasses = 3;

// A rotation of the basis costs it about one unit of rounding of orthonormality, and a polish gives it back.
constexpr int kTurnsBetweenPolishes = 4;
// What is dropped on the way may be missed later: it takes this fraction of the budget, the displayed rank the whole.
constexpr double kFractionOfBudgetOnTheWay = 0.5;
// What packing terms in 8 bits may lose; it is lost at each fold that rotates them.
constexpr double kFractionOfBudgetRounded = 1e-3;

/// What of each column's energy its coordinates do not hold.
template <typename Block>
VectorXd lost_of_columns(const Block& block, const MatrixXd& coordinates) {
  VectorXd lost(block.count);
  for (int j = 0; j < block.count; ++j)
    lost[j] = (block.inside.col(j).squaredNorm() + block.residual2[j]) - coordinates.col(j).squaredNorm();
  return lost;
}

}  // namespace

/// Core coordinates are those of Q = [B' R]: the polished basis B' = B (I - E/2) and the orthonormalised residuals
/// R = (P - B overlap) to_directions, whatever (2) needed to find them.
template <typename Scalar>
struct SvdBasis<Scalar>::Block {
  int count = 0;
  VectorXd weight;            ///< for each column
  VectorXd norm2, residual2;  ///< for each column: ||c||^2, ||p||^2
  double lost = 0;            ///< energy that neither basis nor directions hold
  MatrixXd inside;            ///< rank x count: coefficients in B, Y + H
  MatrixXd outside;           ///< directions x count: coefficients in R
  MatrixXd overlap;           ///< rank x count: H = B^T P, what projecting once left behind
  MatrixXd to_directions;     ///< count x directions
  MatrixXd loss;              ///< E = B^T B - I; empty when the basis will not rotate
};

/// New basis = Q from_core: the leading singular directions of all columns, in core coordinates.
template <typename Scalar>
struct SvdBasis<Scalar>::Rotation {
  int rank = 0, displayed = 0;
  double lost = 0;       ///< energy of the directions left out
  VectorXd spectrum;     ///< rank
  MatrixXd from_core;    ///< core size x rank
  MatrixXd core;         ///< G' of all columns, the block's included
  MatrixXd coordinates;  ///< core size x count: of the block's columns
};

template <typename Scalar>
double SvdBasis<Scalar>::displayed_error() const {
  const double all = energy();
  const double unshown = lost_ + gram_diagonal().tail(rank_ - displayed_).sum();
  return all > 0 ? std::sqrt(unshown / all) : 0;
}

template <typename Scalar>
std::size_t SvdBasis<Scalar>::bytes() const {
  return sizeof(Scalar) * basis_.size() + packed_.bytes() + packed_gram_.bytes() +
         sizeof(double) * (gram_.size() + spectrum_.size());
}

template <typename Scalar>
std::size_t SvdBasis<Scalar>::bytes(int terms) const {
  return packed_.empty() ? sizeof(Scalar) * static_cast<std::size_t>(rows_ * terms) : packed_.bytes(terms);
}

template <typename Scalar>
typename SvdBasis<Scalar>::Matrix SvdBasis<Scalar>::leading(int terms) const {
  if (packed_.empty()) return basis_.topLeftCorner(rows_, terms);
  return packed_.unpacked(0, rows_, terms);
}

template <typename Scalar>
PackedColumns<Scalar> SvdBasis<Scalar>::packed(int terms) const {
  if (packed_.empty()) return Matrix(basis_.topLeftCorner(rows_, terms));
  return packed_.leading(rows_, terms);
}

template <typename Scalar>
Scalar SvdBasis<Scalar>::dot(int row, const Eigen::Ref<const Eigen::Matrix<Scalar, Eigen::Dynamic, 1>>& y) const {
  if (packed_.empty()) return basis_.row(row).head(rank_).dot(y);
  Scalar sum = 0;
  for (int k = 0; k < rank_; ++k) sum += packed_.at(row, k) * y[k];
  return sum;
}

template <typename Scalar>
Eigen::Matrix<Scalar, Eigen::Dynamic, 1> SvdBasis<Scalar>::at_rows(
    std::span<const int> rows, const Eigen::Ref<const Eigen::Matrix<Scalar, Eigen::Dynamic, 1>>& y) const {
  const auto count = static_cast<Eigen::Index>(rows.size());
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> sums = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>::Zero(count);
  const auto add = [&](Eigen::Index k, const auto& value) {
    for (Eigen::Index i = 0; i < count; ++i) sums[i] += y[k] * value(rows[static_cast<std::size_t>(i)]);
  };
  if (packed_.empty())
    for (int k = 0; k < rank_; ++k) add(k, [values = basis_.col(k).data()](int row) { return values[row]; });
  else
    packed_.visit(rank_, add);
  return sums;
}

/// Those that take 16 bits a value.
template <typename Scalar>
Eigen::Index SvdBasis<Scalar>::fine_terms(double tolerance) const {
  double left = kFractionOfBudgetRounded * tolerance * tolerance * energy();
  Eigen::Index fine = rank_;
  for (; fine > 0; --fine) {
    const double step = step_to_reach<std::int8_t>(largest_magnitude(basis_.col(fine - 1).data(), rows_));
    left -= gram_(fine - 1, fine - 1) * rows_ * step * step / 12;  // rounding, evenly spread over a step
    if (left < 0) break;
  }
  return fine;
}

template <typename Scalar>
void SvdBasis<Scalar>::close(double tolerance) {
  if (rank_ == 0) return;
  packed_ = PackedColumns<Scalar>::fixed_point(basis_, fine_terms(tolerance));
  basis_ = Matrix();
  packed_gram_ = PackedGram(gram(), displayed_);
  gram_ = Eigen::MatrixXd();
}

template <typename Scalar>
void SvdBasis<Scalar>::open() {
  if (packed_.empty()) return;
  const Eigen::Index fine = packed_.fine();
  basis_ = packed_.unpacked();
  packed_ = {};
  set_gram(gram());
  if (fine < rank_) orthonormalise_behind(static_cast<int>(fine));
}

/// The terms behind the first: [B R] <- [B R] T^-1 with T = [I X; 0 U], X = B^T R and U^T U = R^T R - X^T X.
template <typename Scalar>
void SvdBasis<Scalar>::orthonormalise_behind(int first) {
  const Columns all{basis_.data(), basis_.rows(), rank_}, behind = all.from(first);
  const MatrixXd products = row_panels::inner_products<Scalar>(all, behind, basis_.rows());
  const MatrixXd x = products.topRows(first);
  const Eigen::LLT<MatrixXd> cholesky(products.bottomRows(behind.count) - x.transpose() * x);
  if (cholesky.info() != Eigen::Success) return;
  const MatrixXd inverse = cholesky.matrixU().solve(MatrixXd::Identity(behind.count, behind.count));
  MatrixXd from_all(rank_, behind.count);
  from_all << -x * inverse, inverse;
  row_panels::combine<Scalar>(all, {}, from_all.template cast<Scalar>(), basis_.rows(), behind);
}

template <typename Scalar>
MatrixXd SvdBasis<Scalar>::project(const row_panels::Columns<const Scalar>& columns) const {
  return row_panels::inner_products(this->columns(), columns, basis_.rows());
}

template <typename Scalar>
Fold SvdBasis<Scalar>::fold(const Columns& columns, const VectorXd& weights, const MatrixXd& y,
                            std::span<const std::uint64_t> hidden, const OnlineSvdOptions& options) {
  Block block;
  block.count = static_cast<int>(weights.size());
  block.weight = weights;
  block.norm2 = row_panels::squared_norms<Scalar>(columns, columns.stride);
  const Matrix projected = y.template cast<Scalar>();  // (1), as P can be made with it
  block.inside = projected.template cast<double>();
  if (rank_ > 0) row_panels::combine<Scalar>(this->columns(), {}, -projected, basis_.rows(), columns, true);
  for (std::size_t row = 0; row < hidden.size(); ++row)
    for (std::uint64_t bits = hidden[row]; bits != 0; bits &= bits - 1) columns.column(std::countr_zero(bits))[row] = 0;
  split_residuals(columns, block, options);
  return absorb(columns, block, options);
}

/// (2): separates what the basis does not hold of the block, and orthonormalises it where it may not be lost.
template <typename Scalar>
void SvdBasis<Scalar>::split_residuals(const Columns& columns, Block& block, const OnlineSvdOptions& options) const {
  const int count = block.count;
  const row_panels::Columns<const Scalar> residuals = columns;
  block.overlap = row_panels::inner_products(this->columns(), residuals, columns.stride);
  block.inside += block.overlap;
  const VectorXd norm2 = row_panels::squared_norms(residuals, columns.stride);
  block.residual2 = norm2;
  double energy_after = energy();
  for (int j = 0; j < count; ++j) {
    double& residual2 = block.residual2[j];
    residual2 = std::max(0.0, residual2 - block.overlap.col(j).squaredNorm());
    if (residual2 <= kNoise<Scalar> * kNoise<Scalar> * block.norm2[j]) residual2 = 0;
    block.lost += block.weight[j] * residual2;
    energy_after += block.weight[j] * (residual2 + block.inside.col(j).squaredNorm());
  }
  block.outside = MatrixXd::Zero(0, count);
  block.to_directions = MatrixXd::Zero(count, 0);
  if (lost_ + block.lost <= kFractionOfBudgetOnTheWay * options.tolerance * options.tolerance * energy_after) return;
  MatrixXd gram = row_panels::gram(residuals, columns.stride, norm2);
  gram.noalias() -= block.overlap.transpose() * block.overlap;
  Orthonormalised orthonormal = orthonormalise(std::move(gram), block.residual2, kSmallestPivot<Scalar>);
  block.to_directions = std::move(orthonormal.to_directions);
  block.outside = std::move(orthonormal.coefficients);
  block.lost = 0;
  for (int j = 0; j < count; ++j)
    block.lost += block.weight[j] * std::max(0.0, block.residual2[j] - block.outside.col(j).squaredNorm());
}

/// How many terms to keep and how many of them to display. `descending`: squared singular values; `lost`: energy
/// without any direction.
template <typename Scalar>
void SvdBasis<Scalar>::choose_rank(const VectorXd& descending, double lost, const OnlineSvdOptions& options,
                                   Rotation& rotation) const {
  const double energy = lost + descending.sum();
  const double budget = options.tolerance * options.tolerance * energy;
  // of the columns, and of the eigenvalues, which are no more exact than the largest of them
  const double rounding =
      std::max(kNoise<Scalar> * kNoise<Scalar>, 4 * std::numeric_limits<double>::epsilon()) * energy;
  rotation.rank = static_cast<int>(descending.size());
  while (rotation.rank > 0) {
    const double next = descending[rotation.rank - 1];
    const bool affordable = lost + rotation.lost + next <= kFractionOfBudgetOnTheWay * budget;
    if (!affordable && next > rounding && rotation.rank <= options.terms_kept()) break;
    rotation.lost += next;
    --rotation.rank;
  }
  rotation.displayed = rotation.rank;
  for (double hidden = lost + rotation.lost; rotation.displayed > 0; --rotation.displayed) {
    hidden += descending[rotation.displayed - 1];
    if (hidden > budget && rotation.displayed <= options.max_rank) break;
  }
}

/// Orthonormalises the directions of the block once more, now as columns of their own, whose squared norms it returns.
template <typename Scalar>
VectorXd SvdBasis<Scalar>::orthonormalise_again(const Columns& columns, Block& block) const {
  const auto columns_before = static_cast<int>(block.to_directions.rows());
  const auto directions = static_cast<int>(block.to_directions.cols());
  Matrix m(rank_ + columns_before, directions);
  m << (-block.overlap * block.to_directions).template cast<Scalar>(), block.to_directions.template cast<Scalar>();
  row_panels::combine<Scalar>(this->columns(), columns.first(columns_before), m, columns.stride,
                              columns.first(directions));
  const row_panels::Columns<const Scalar> residuals = columns.first(directions);
  block.overlap = row_panels::inner_products(this->columns(), residuals, columns.stride);
  MatrixXd gram = row_panels::gram(residuals, columns.stride);
  VectorXd norm2 = gram.diagonal();
  gram.noalias() -= block.overlap.transpose() * block.overlap;
  const Orthonormalised once_more = orthonormalise(gram, gram.diagonal().cwiseMax(0), kSmallestPivot<Scalar>);
  block.to_directions = once_more.to_directions;
  block.inside += block.overlap * block.outside;
  block.outside = once_more.coefficients * block.outside;
  return norm2;
}

/// (3) and (4).
template <typename Scalar>
typename SvdBasis<Scalar>::Rotation SvdBasis<Scalar>::singular_rotation(const Block& block,
                                                                        const OnlineSvdOptions& options) const {
  const Eigen::Index directions = block.outside.rows(), size = rank_ + directions;
  if (size == 0) return {.coordinates = MatrixXd::Zero(0, block.count)};
  MatrixXd z(size, block.count);
  if (block.count > 0) {
    z.topRows(rank_) = block.inside;
    z.bottomRows(directions) = block.outside;
    if (block.loss.size() > 0) z.topRows(rank_) += 0.5 * block.loss * block.inside;  // in the polished basis
  }
  // G and Y hold what was meant: E is what rounding did to B since, mostly with one sign, and where B is rounded back
  // to where it was, again the same. It would wear them down fold by fold.
  MatrixXd core = MatrixXd::Zero(size, size);
  core.topLeftCorner(rank_, rank_) = gram_;
  core.noalias() += z * block.weight.asDiagonal() * z.transpose();

  Rotation rotation;
  const SymmetricEigen eigen = symmetric_eigen(core);
  rotation.spectrum = eigen.values.cwiseMax(0);
  choose_rank(rotation.spectrum, lost_ + block.lost, options, rotation);
  rotation.spectrum.conservativeResize(rotation.rank);
  rotation.coordinates = std::move(z);
  rotation.core = std::move(core);
  rotation.from_core = eigen.vectors.leftCols(rotation.rank);
  return rotation;
}

/// What rounding in the inner products of the residuals, times their norms, is magnified by on its way to the basis.
template <typename Scalar>
double SvdBasis<Scalar>::growth(const Block& block, const VectorXd& norm2, const Rotation& rotation) const {
  if (rotation.rank == 0) return 0;
  const MatrixXd reach =
      norm2.cwiseSqrt().asDiagonal() * block.to_directions * rotation.from_core.bottomRows(block.outside.rows());
  return reach.colwise().squaredNorm().maxCoeff();
}

/// Adds the block to G, and rotates the basis to the new singular directions where there are any.
template <typename Scalar>
Fold SvdBasis<Scalar>::absorb(const Columns& columns, Block& block, const OnlineSvdOptions& options) {
  const bool grows = block.outside.rows() > 0;
  const auto polish = [&] {
    block.loss = row_panels::gram(this->columns(), basis_.rows());
    block.loss.diagonal().array() -= 1;
  };
  const bool rotates = grows || rank_ > displayed_ || block.count == 0;
  if (rotates) {
    if (rotations_ == 0) polish();
    rotations_ = (rotations_ + 1) % kTurnsBetweenPolishes;
  }
  Rotation rotation = singular_rotation(block, options);
  Fold fold;
  if (!rotates && rotation.displayed == rank_) {  // nothing new: the basis stays as it is
    gram_ = rotation.core;
    spectrum_ = rotation.spectrum;
    lost_ += block.lost;
    fold.coordinates = std::move(rotation.coordinates);
  } else {
    if (grows) {
      // Those of columns with hidden rows may lie mostly within B.
      VectorXd norm2 = block.residual2 + block.overlap.colwise().squaredNorm().transpose();
      for (int pass = 1; pass < kMostPasses && growth(block, norm2, rotation) > kLargestGrowth; ++pass) {
        norm2 = orthonormalise_again(columns, block);
        rotation = singular_rotation(block, options);
      }
    }
    fold.rotation = apply(columns, rotation, block);
    fold.coordinates =
        rank_ > 0 ? MatrixXd(rotation.from_core.transpose() * rotation.coordinates) : MatrixXd::Zero(0, block.count);
  }
  fold.lost = lost_of_columns(block, fold.coordinates);
  fold.norm2 = std::move(block.norm2);
  fold.residual2 = std::move(block.residual2);
  return fold;
}

/// Nothing is left but zeros, or less than the tolerance.
template <typename Scalar>
void SvdBasis<Scalar>::forget_directions(const Rotation& rotation, const Block& block) {
  basis_.resize(row_panels::padded(rows_), 0);
  gram_.resize(0, 0);
  spectrum_.resize(0);
  lost_ += block.lost + rotation.lost;
  rank_ = displayed_ = 0;
}

/// (5). The residuals that (2) left in `columns` become part of the basis.
template <typename Scalar>
BasisRotation SvdBasis<Scalar>::apply(const Columns& columns, Rotation& rotation, const Block& block) {
  if (rotation.rank == 0) {
    forget_directions(rotation, block);
    return {.kind = BasisRotation::Kind::kGone, .new_from_old = {}};
  }
  const Eigen::Index directions = block.outside.rows();
  const Eigen::Index displayed = rotation.displayed;
  const MatrixXd alignment = aligning_rotation(rotation.from_core.leftCols(displayed), displayed_);
  rotation.from_core.leftCols(displayed) = (rotation.from_core.leftCols(displayed) * alignment).eval();

  const MatrixXd from_basis = rotation.from_core.topRows(rank_);
  MatrixXd half = MatrixXd::Zero(rank_, rotation.rank);  // E/2 of it
  if (block.loss.size() > 0) half = 0.5 * block.loss * from_basis;
  const MatrixXd from_residuals = block.to_directions * rotation.from_core.bottomRows(directions);
  Matrix m(rank_ + from_residuals.rows(), rotation.rank);
  m.topRows(rank_) = (from_basis - half - block.overlap * from_residuals).template cast<Scalar>();
  m.bottomRows(from_residuals.rows()) = from_residuals.template cast<Scalar>();
  const row_panels::Columns<const Scalar> residuals = columns.first(static_cast<int>(from_residuals.rows()));
  const Eigen::Index padded = row_panels::padded(rows_);
  if (rotation.rank == basis_.cols()) {
    row_panels::combine<Scalar>(this->columns(), residuals, m, padded, {basis_.data(), padded, rotation.rank});
  } else {
    Matrix rotated(padded, rotation.rank);
    row_panels::combine<Scalar>(this->columns(), residuals, m, padded, {rotated.data(), padded, rotation.rank});
    basis_ = std::move(rotated);
  }
  gram_ = rotation.spectrum.asDiagonal();
  gram_.topLeftCorner(displayed, displayed) =
      alignment.transpose() * rotation.spectrum.head(displayed).asDiagonal() * alignment;
  spectrum_ = rotation.spectrum;
  lost_ += block.lost + rotation.lost;
  rank_ = rotation.rank;
  displayed_ = rotation.displayed;
  return {.kind = BasisRotation::Kind::kRotated, .new_from_old = from_basis};
}

template <typename Scalar>
BasisRotation SvdBasis<Scalar>::restore_order(const OnlineSvdOptions& options) {
  if (rank_ == 0) return {};
  Block nothing;
  nothing.inside = nothing.overlap = MatrixXd::Zero(rank_, 0);
  nothing.outside = nothing.to_directions = MatrixXd::Zero(0, 0);
  return absorb({nullptr, basis_.rows(), 0}, nothing, options).rotation;
}

template <typename Scalar>
std::vector<MatrixXd> SvdBasis<Scalar>::restore_orthonormality() {
  std::vector<MatrixXd> steps;
  for (int pass = 0; pass < 2; ++pass) {  // the first leaves rounding times the condition of the rows' Gram matrix
    const Eigen::LLT<MatrixXd> cholesky(row_panels::gram(columns(), basis_.rows()));
    if (cholesky.info() != Eigen::Success) return steps;
    // B <- B R^-1, Y <- R Y
    const MatrixXd r = cholesky.matrixU();
    const MatrixXd inverse = cholesky.matrixU().solve(MatrixXd::Identity(rank_, rank_));
    row_panels::combine<Scalar>(columns(), {}, inverse.template cast<Scalar>(), basis_.rows(),
                                {basis_.data(), basis_.rows(), rank_});
    gram_ = (r * gram_ * r.transpose()).eval();
    steps.push_back(r);
  }
  return steps;
}

template <typename Scalar>
MatrixXd SvdBasis<Scalar>::replace_rows(const Matrix& rows) {
  lost_ *= static_cast<double>(rows.rows()) / rows_;
  rows_ = static_cast<int>(rows.rows());
  basis_ = Matrix::Zero(row_panels::padded(rows_), rank_);
  basis_.topRows(rows_) = rows;
  if (rank_ == 0) return MatrixXd::Zero(0, 0);
  const MatrixXd gram = row_panels::gram(columns(), basis_.rows());
  const Orthonormalised orthonormal = orthonormalise(gram, gram.diagonal().cwiseMax(0), kSmallestPivot<Scalar>);
  basis_ = (basis_ * orthonormal.to_directions.template cast<Scalar>()).eval();
  gram_ = (orthonormal.coefficients * gram_ * orthonormal.coefficients.transpose()).eval();
  rank_ = static_cast<int>(basis_.cols());
  displayed_ = std::min(displayed_, rank_);
  MatrixXd factor = orthonormal.coefficients;
  for (const MatrixXd& step : restore_orthonormality()) factor = (step * factor).eval();
  return factor;
}

template class SvdBasis<float>;
template class SvdBasis<double>;

}  // namespace sheen
