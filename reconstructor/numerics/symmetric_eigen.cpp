// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/symmetric_eigen.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "reconstructor/numerics/row_panels.h"

namespace sheen {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using row_panels::load;
using row_panels::store;
using Lanes = row_panels::Vector<double>;

constexpr Index kLanes = row_panels::VectorOf<double>::kLanes;

/// sum = columns [first, cols) of a, each times its factor; whole vectors of rows from `row` on.
void combine_columns(const MatrixXd& a, Index first, const VectorXd& factor, Index row, VectorXd& sum) {
  constexpr int kChains = 4;  // which do not wait for each other
  const double* times = factor.data();
  const Index cols = a.cols(), stride = a.rows();
  for (; row < stride; row += kLanes) {
    Lanes chain[kChains] = {};
    const double* from = &a(row, first);
    Index j = first;
    for (; j + kChains <= cols; j += kChains, from += kChains * stride)
#pragma GCC unroll 4
      for (int k = 0; k < kChains; ++k) chain[k] += load(from + k * stride) * times[j + k];
    for (; j < cols; ++j, from += stride) chain[0] += load(from) * times[j];
    store(&sum[row], (chain[0] + chain[1]) + (chain[2] + chain[3]));
  }
}

/// a -= v w^T in columns [first, cols), whole vectors of rows from `row` on.
void subtract_outer_product(const VectorXd& v, const VectorXd& w, Index first, Index row, MatrixXd& a) {
  const double* times = w.data();
  const Index cols = a.cols(), stride = a.rows();
  for (; row < stride; row += kLanes) {
    const Lanes left = load(&v[row]);
    double* to = &a(row, first);
    for (Index j = first; j < cols; ++j, to += stride) store(to, load(to) - left * times[j]);
  }
}

/// A matrix on the way to its eigenvalues; columns are padded with zeros to whole vectors.
class Solver {
 public:
  explicit Solver(const MatrixXd& a)
      : size_(a.rows()),
        a_(MatrixXd::Zero((size_ + kLanes - 1) / kLanes * kLanes, size_)),
        vectors_(MatrixXd::Zero(a_.rows(), size_)),
        diagonal_(size_),
        coupling_(VectorXd::Zero(size_)) {
    const double peak = size_ > 0 ? a.cwiseAbs().maxCoeff() : 0;
    if (peak > 0) exponent_ = std::max(std::ilogb(peak), std::numeric_limits<double>::min_exponent);
    a_.topRows(size_) = std::ldexp(1.0, -exponent_) * a.reverse();  // QL wants the small ones first
    vectors_.diagonal().setOnes();
  }

  SymmetricEigen solve() {
    tridiagonalise();
    diagonalise();
    std::vector<int> order(size_);
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return diagonal_[i] > diagonal_[j]; });
    return {std::ldexp(1.0, exponent_) * diagonal_(order),
            vectors_.topRows(size_).colwise().reverse()(Eigen::all, order)};
  }

 private:
  /// Reflects column after column to its diagonal and the number below; `vectors_` becomes the product of the
  /// reflections.
  void tridiagonalise() {
    VectorXd v = VectorXd::Zero(a_.rows()), w(a_.rows()), moved(a_.rows());
    for (Index i = 0; i + 1 < size_; ++i) {
      diagonal_[i] = a_(i, i);
      coupling_[i] = a_(i + 1, i);
      const Index below = size_ - i - 1, row = (i + 1) / kLanes * kLanes;
      v.setZero();
      v.segment(i + 1, below) = a_.col(i).segment(i + 1, below);
      const double rest2 = v.tail(v.size() - i - 2).squaredNorm();
      if (!(rest2 > 0)) continue;
      coupling_[i] = -std::copysign(std::sqrt(v[i + 1] * v[i + 1] + rest2), v[i + 1]);
      v[i + 1] -= coupling_[i];
      const double tau = 2 / (v[i + 1] * v[i + 1] + rest2);
      // A <- H A H with H = I - tau v v^T: A - v w^T - w v^T
      combine_columns(a_, i + 1, v, row, w);
      w.head(i + 1).setZero();
      w *= tau;
      w -= (0.5 * tau * w.dot(v)) * v;
      subtract_outer_product(v, w, i + 1, row, a_);
      subtract_outer_product(w, v, i + 1, row, a_);
      combine_columns(vectors_, i + 1, v, 0, moved);
      moved *= tau;
      subtract_outer_product(moved, v, i + 1, 0, vectors_);
    }
    if (size_ > 0) diagonal_[size_ - 1] = a_(size_ - 1, size_ - 1);
  }

  bool negligible(Index i) const {
    const double scale = std::abs(diagonal_[i]) + std::abs(diagonal_[i + 1]) + 0.01;  // of a matrix of norm 1 or more
    return std::abs(coupling_[i]) <= std::numeric_limits<double>::epsilon() * scale;
  }

  void diagonalise() {
    constexpr int kMostSteps = 40;  // an eigenvalue; three are usual
    constexpr int kPairs = 3;       // Wilkinson's shift alone always leads to the end
    for (Index first = 0; first < size_; ++first)
      for (int step = 0; step < kMostSteps; ++step) {
        Index last = first;
        while (last + 1 < size_ && !negligible(last)) ++last;
        if (last == first) break;
        step_down(first, last, step < kPairs && last > first + 1);
      }
  }

  /// A QL step on its way from row `last` up (Parlett, 8.13).
  struct Sweep {
    Index last;
    double shift;
    double pivot;             ///< what stands on the diagonal where the next rotation takes place
    double shifted;           ///< what will, when all rotations are through, less the shift
    double cos = 1, sin = 0;  ///< of the last rotation
  };

  Sweep begin(Index last, double shift) const {
    return {.last = last, .shift = shift, .pivot = diagonal_[last] - shift, .shifted = diagonal_[last] - shift};
  }
  /// The numbers of the rotation of rows i and i + 1. It reaches the vectors when the next one is known: so neither
  /// waits for the other.
  void advance(Sweep& sweep, Index i) {
    const double coupled = sweep.cos * coupling_[i], before = sweep.shifted;
    const double norm = std::sqrt(sweep.pivot * sweep.pivot + coupling_[i] * coupling_[i]);
    if (i + 1 < sweep.last) {
      coupling_[i + 1] = sweep.sin * norm;
      rotate(i + 1, sweep.cos, sweep.sin);
    }
    const double inverse = 1 / norm;
    sweep.cos = norm > 0 ? sweep.pivot * inverse : 1;
    sweep.sin = norm > 0 ? coupling_[i] * inverse : 0;
    sweep.pivot = sweep.cos * (diagonal_[i] - sweep.shift) - sweep.sin * coupled;
    sweep.shifted = sweep.cos * sweep.pivot;
    diagonal_[i + 1] = before + (diagonal_[i] - sweep.shifted);
  }
  void finish(const Sweep& sweep, Index first) {
    coupling_[first] = sweep.sin * sweep.pivot;
    diagonal_[first] = sweep.shift + sweep.shifted;
    rotate(first, sweep.cos, sweep.sin);
  }

  /// A QL step on rows first..last with Wilkinson's shift; or a pair, of which the second is a row behind, with both
  /// eigenvalues of the first two rows.
  void step_down(Index first, Index last, bool pair) {
    const double ratio = (diagonal_[first + 1] - diagonal_[first]) / (2 * coupling_[first]);
    const double turn = coupling_[first] / (ratio + std::copysign(std::sqrt(ratio * ratio + 1), ratio));
    Sweep near = begin(last, diagonal_[first] - turn);
    const double far_shift = diagonal_[first + 1] + turn;
    Index i = last - 1;
    advance(near, i);
    if (pair) {
      Sweep far = begin(last, far_shift);
      for (--i; i >= first; --i) {
        advance(near, i);
        advance(far, i + 1);
      }
      finish(near, first);
      advance(far, first);
      finish(far, first);
    } else {
      for (--i; i >= first; --i) advance(near, i);
      finish(near, first);
    }
  }

  void rotate(Index i, double c, double s) {
    double* left = vectors_.col(i).data();
    double* right = vectors_.col(i + 1).data();
    for (Index r = 0; r < vectors_.rows(); r += kLanes) {
      const Lanes x = load(left + r), y = load(right + r);
      store(left + r, c * x - s * y);
      store(right + r, s * x + c * y);
    }
  }

  Index size_;
  int exponent_ = 0;
  MatrixXd a_, vectors_;
  VectorXd diagonal_, coupling_;  ///< of the tridiagonal matrix, and beside it
};

}  // namespace

SymmetricEigen symmetric_eigen(const MatrixXd& a) {
  return Solver(a).solve();
}

}  // namespace sheen
