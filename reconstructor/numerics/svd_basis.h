// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "reconstructor/numerics/online_svd_options.h"
#include "reconstructor/numerics/packed_columns.h"
#include "reconstructor/numerics/packed_gram.h"
#include "reconstructor/numerics/row_bits.h"
#include "reconstructor/numerics/row_panels.h"

namespace sheen {

/// How a fold rotated the basis: what a coefficient vector y of a folded view becomes.
struct BasisRotation {
  enum class Kind {
    kNone,     ///< y stays
    kRotated,  ///< new_from_old^T y
    kGone,     ///< nothing: rank 0
  };
  Kind kind = Kind::kNone;
  Eigen::MatrixXd new_from_old;  ///< old rank x new rank
};

/// What folding a block in did.
struct Fold {
  BasisRotation rotation;
  Eigen::VectorXd norm2, residual2;  ///< for each column: ||c||^2, ||p||^2
  Eigen::MatrixXd coordinates;       ///< new rank x columns: of the block in the new basis
  Eigen::VectorXd lost;              ///< for each column: ||c||^2 less that of its coordinates
};

/// The basis of the online SVD, and the algebra of a fold. With n rows, r terms, and the k columns C of a
/// block with their weights w (W = diag w):
///
///   B  n x r   orthonormal        G  r x r  sum of w y y^T over all columns folded so far (double)
///
///   (1)  Y = B^T C,  P = C - B Y                           000 sec. 3.1, a block at a time                  n r k
///   (2)  H = B^T P,  P^T P - H^T H = L L^T (pivoted)       R = (P - B H) L^-T instead of p / ||p||    n (r k + k^2)
///   (3)  G' = [G 0; 0 0] + Z W Z^T,  Z = [Y + H; L^T]      of all columns in the coordinates of Q = [B R]      r k^2
///   (4)  G' = V S^2 V^T                                    the small eigenproblem, in double              (r + k)^3
///   (5)  B <- Q V,  y <- V^T y,  G <- S^2                  the leading columns of V alone; one pass     n (r + k) r
///
/// H is the second projection of "twice is enough": P was rounded, and what that left of B in it is not lost. Every
/// few rotations E = B^T B - I is measured too and (5) starts from B (I - E/2): the polish, which gives back what
/// rounding took from the basis. R and the polished basis are never written out: both are in the one matrix that (5)
/// multiplies [B P] by. Only where P^T P is so ill-conditioned that this would magnify its rounding is R written over P
/// and orthonormalised once more.
///
/// The first `displayed()` columns of B span the leading singular subspace and are rotated as little as possible from
/// fold to fold (Procrustes: V's leading columns times the orthogonal factor of their overlap with the old frame); the
/// rest is in singular order. So G is diagonal but for its leading displayed x displayed block.
///
/// Energy is counted exactly: B is orthonormal, so what is dropped is orthogonal to what is kept, and the sum of
/// w ||c||^2 over all columns is trace G + lost.
///
/// Between folds the basis may be closed: B is packed, in fixed point, and G as the numbers that it is made of. Then
/// only sizes, G, single values (`dot`) and copies can be asked for; all else asks for an open basis.
template <typename Scalar>
class SvdBasis {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Columns = row_panels::Columns<Scalar>;

  explicit SvdBasis(int rows) : rows_(rows) { basis_.resize(row_panels::padded(rows), 0); }

  int rows() const { return rows_; }
  int rank() const { return rank_; }
  int displayed() const { return displayed_; }
  Matrix leading(int terms) const;                ///< rows x terms
  PackedColumns<Scalar> packed(int terms) const;  ///< the same, packed as it is
  auto row(int row) const { return basis_.row(row).head(rank_); }
  Scalar dot(int row, const Eigen::Ref<const Eigen::Matrix<Scalar, Eigen::Dynamic, 1>>& y) const;  ///< of a row and y
  /// The same of many rows.
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> at_rows(
      std::span<const int> rows, const Eigen::Ref<const Eigen::Matrix<Scalar, Eigen::Dynamic, 1>>& y) const;
  row_panels::Columns<const Scalar> columns() const { return row_panels::columns(basis_, rank_); }
  Eigen::MatrixXd gram() const { return packed_gram_.empty() ? gram_ : packed_gram_.unpacked(); }
  const Eigen::VectorXd& spectrum() const { return spectrum_; }  ///< squared singular values, descending
  double lost() const { return lost_; }
  double energy() const { return gram_diagonal().sum() + lost_; }
  double displayed_error() const;  ///< root of the fraction of the energy that the displayed terms do not hold
  std::size_t bytes() const;
  std::size_t bytes(int terms) const;  ///< of `packed`, with rows that pad it

  /// Packs it: 16 bits a value, and 8 in the last terms as far as these are off by far less than the tolerance allows.
  /// Such terms are no longer quite orthonormal.
  void close(double tolerance);
  /// Unpacks it, orthonormal (as it was packed where rounding left its terms dependent). Coefficients stay as they are:
  /// were they to follow, what rounding did would be theirs for good, and again with each fold.
  void open();

  /// B^T of columns that are as long as the padded rows: rank x columns.
  Eigen::MatrixXd project(const row_panels::Columns<const Scalar>& columns) const;

  /// Folds a block in. `columns`: of padded length; the fold leaves nothing of use in them.
  /// `y`: B^T C, hidden rows at what they are imputed to be; these are then B y, and P is 0 there. `hidden`: which of
  /// the columns hide a row, or empty.
  Fold fold(const Columns& columns, const Eigen::VectorXd& weights, const Eigen::MatrixXd& y,
            std::span<const std::uint64_t> hidden, const OnlineSvdOptions& options);

  /// Restores the singular order, and gives back the rank that the options do not ask for.
  BasisRotation restore_order(const OnlineSvdOptions& options);

  /// Gives rows that were zero values, row by row, and then makes B orthonormal again. Returns what coefficients are to
  /// be multiplied by, one matrix after the other: r x r each.
  void set_row(int row, const Eigen::VectorXd& values) {
    basis_.row(row).head(rank_) = values.transpose().template cast<Scalar>();
  }
  std::vector<Eigen::MatrixXd> restore_orthonormality();

  /// Other rows in place of those of B, which need not be orthonormal; B then is. Returns what coefficients are to be
  /// multiplied by: new rank x old. What was lost is taken to be as much for each row as before.
  Eigen::MatrixXd replace_rows(const Matrix& rows);

  void set_gram(Eigen::MatrixXd gram) {
    gram_ = std::move(gram);
    packed_gram_ = {};
  }
  /// Of a column of this weight, so much less (or more) was lost than was counted.
  void count_lost(double weight, double energy) { lost_ = std::max(0.0, lost_ + weight * energy); }

 private:
  struct Block;
  struct Rotation;

  Eigen::VectorXd gram_diagonal() const {
    return packed_gram_.empty() ? Eigen::VectorXd(gram_.diagonal()) : packed_gram_.diagonal();
  }
  Eigen::Index fine_terms(double tolerance) const;
  void orthonormalise_behind(int first);
  void split_residuals(const Columns& columns, Block& block, const OnlineSvdOptions& options) const;
  Eigen::VectorXd orthonormalise_again(const Columns& columns, Block& block) const;
  void choose_rank(const Eigen::VectorXd& descending, double lost, const OnlineSvdOptions& options,
                   Rotation& rotation) const;
  Rotation singular_rotation(const Block& block, const OnlineSvdOptions& options) const;
  double growth(const Block& block, const Eigen::VectorXd& norm2, const Rotation& rotation) const;
  Fold absorb(const Columns& columns, Block& block, const OnlineSvdOptions& options);
  BasisRotation apply(const Columns& columns, Rotation& rotation, const Block& block);
  void forget_directions(const Rotation& rotation, const Block& block);

  int rows_;
  int rank_ = 0, displayed_ = 0;
  int rotations_ = 0;  ///< of the basis since the last polish, that one included
  double lost_ = 0;    ///< energy of the folded columns that B does not hold
  Matrix basis_;       ///< padded rows x rank; empty while it is packed
  PackedColumns<Scalar> packed_;
  Eigen::MatrixXd gram_;
  PackedGram packed_gram_;  ///< in its place while the basis is closed
  Eigen::VectorXd spectrum_;
};

}  // namespace sheen
