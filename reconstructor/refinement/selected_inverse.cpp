// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/selected_inverse.h"

#include <vector>

namespace sheen {

Eigen::VectorXd diagonal_of_inverse(const Eigen::SimplicialLDLT<SparseMatrix>& factor) {
  using Index = Eigen::Index;
  const SparseMatrix lower = factor.matrixL().nestedExpression().eval();
  const Eigen::VectorXd d = factor.vectorD();
  const Index n = d.size();
  // Z = A^-1 (permuted) on the pattern of L: Z_ij = -sum_{k > j} Z_ik L_kj for i > j, and the diagonal from it:
  // Z_jj = 1 / d_j - sum_{k > j} Z_kj L_kj.
  SparseMatrix inverse = lower;  // the pattern; values are replaced column by column
  Eigen::VectorXd diagonal = d.cwiseInverse();
  Eigen::VectorXd column = Eigen::VectorXd::Zero(n);  // of L, where a column of L has entries
  std::vector<double> z;
  std::vector<Index> rows;
  for (Index j = n - 1; j >= 0; --j) {
    rows.clear();
    for (SparseMatrix::InnerIterator it(lower, j); it; ++it)
      if (it.row() > j) {
        rows.push_back(it.row());
        column[it.row()] = it.value();
      }
    z.assign(rows.size(), 0);
    // Each pair of rows (i > k) of the column has an entry in column k of L's pattern.
    for (std::size_t a = 0; a < rows.size(); ++a) {
      const Index k = rows[a];
      z[a] -= diagonal[k] * column[k];
      std::size_t b = a + 1;
      for (SparseMatrix::InnerIterator it(inverse, k); it && b < rows.size(); ++it) {
        if (it.row() < rows[b]) continue;
        z[a] -= it.value() * column[rows[b]];
        z[b] -= it.value() * column[k];
        ++b;
      }
    }
    double own = diagonal[j];
    std::size_t a = 0;
    for (SparseMatrix::InnerIterator it(inverse, j); it; ++it) {
      if (it.row() <= j) continue;
      it.valueRef() = z[a];
      own -= z[a] * column[it.row()];
      ++a;
    }
    diagonal[j] = own;
    for (const Index row : rows) column[row] = 0;
  }
  return factor.permutationPinv() * diagonal;
}

}  // namespace sheen
