// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/orthonormal.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sheen {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Orthonormalised orthonormalise(MatrixXd gram, const VectorXd& norm2, double smallest_pivot) {
  const Eigen::Index count = gram.rows();
  // Residuals differ in size by orders of magnitude; scaled to one norm, none is lost beside another.
  const VectorXd norm = norm2.cwiseSqrt();
  const VectorXd scale = (norm2.array() > 0).select(norm.cwiseInverse(), 0.0);
  gram = (scale.asDiagonal() * gram * scale.asDiagonal()).eval();
  std::vector<int> order;
  MatrixXd lower = MatrixXd::Zero(count, count);  // lower.leftCols(n) lower.leftCols(n)^T -> gram
  VectorXd left = gram.diagonal();
  for (Eigen::Index n = 0; n < count; ++n) {
    Eigen::Index next;
    const double pivot = left.maxCoeff(&next);
    if (!(pivot > smallest_pivot)) break;
    auto column = lower.col(n);
    column = gram.col(next);
    column.noalias() -= lower.leftCols(n) * lower.row(next).head(n).transpose();
    column /= std::sqrt(pivot);
    for (const int earlier : order) column[earlier] = 0;
    left -= column.cwiseAbs2();
    order.push_back(static_cast<int>(next));
    for (const int done : order) left[done] = -1;
  }
  const auto directions = static_cast<Eigen::Index>(order.size());
  const MatrixXd upper = lower.leftCols(directions).transpose();
  const MatrixXd triangle = upper(Eigen::all, order);
  const MatrixXd inverse = triangle.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(directions, directions));
  Orthonormalised result{MatrixXd::Zero(count, directions), upper * norm.asDiagonal()};
  for (Eigen::Index i = 0; i < directions; ++i) result.to_directions.row(order[i]) = scale[order[i]] * inverse.row(i);
  return result;
}

MatrixXd aligning_rotation(const MatrixXd& leading, Eigen::Index old_displayed) {
  const Eigen::Index size = leading.cols(), common = std::min(size, old_displayed);
  MatrixXd reflected(common + size, size);  // transposed, for long columns: the triangle above the reflections
  reflected << leading.topRows(common), MatrixXd::Identity(size, size);
  VectorXd v, image;
  for (Eigen::Index i = 0; i < common; ++i) {
    v = reflected.row(i).tail(size - i);
    v[0] += std::copysign(v.norm(), v[0]);
    const double norm2 = v.squaredNorm();
    if (!(norm2 > 0)) continue;
    auto left = reflected.rightCols(size - i);
    image.noalias() = left * v;
    left.noalias() -= image * (2 / norm2 * v).transpose();
  }
  for (Eigen::Index i = 0; i < common; ++i)
    if (reflected(i, i) < 0) reflected.col(i) = -reflected.col(i);
  return reflected.bottomRows(size);
}

}  // namespace sheen
