// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plain_brand.h"

#include <Eigen/SVD>
#include <algorithm>

namespace sheen {

void PlainBrand::add(const Eigen::VectorXd& column) {
  const Eigen::Index k = s_.size(), n = v_.rows();
  const Eigen::VectorXd j = u_.transpose() * column;
  const Eigen::VectorXd p = column - u_ * j;
  const double rest = p.norm();
  const bool grows = rest > options_.tolerance && !(options_.freezes && k == options_.cap);

  // K = [S j; 0 ||p||], the SVD of which rotates U and V.
  const Eigen::Index size = grows ? k + 1 : k;
  Eigen::MatrixXd core = Eigen::MatrixXd::Zero(size, k + 1);
  core.topLeftCorner(k, k) = s_.asDiagonal();
  core.col(k).head(k) = j;
  if (grows) core(k, k) = rest;
  const Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::FullPivHouseholderQRPreconditioner> svd(
      core, Eigen::ComputeFullU | Eigen::ComputeFullV);

  Eigen::MatrixXd u(u_.rows(), size);
  u.leftCols(k) = u_;
  if (grows) u.col(k) = p / rest;
  Eigen::MatrixXd v = Eigen::MatrixXd::Zero(n + 1, k + 1);
  v.topLeftCorner(n, k) = v_;
  v(n, k) = 1;

  const Eigen::Index kept = std::min<Eigen::Index>(size, options_.cap);
  u_ = u * svd.matrixU().leftCols(kept);
  v_ = v * svd.matrixV().leftCols(kept);
  s_ = svd.singularValues().head(kept);
}

Eigen::MatrixXd PlainBrand::model(int rank) const {
  const Eigen::Index k = std::min<Eigen::Index>(rank, s_.size());
  return u_.leftCols(k) * s_.head(k).asDiagonal() * v_.leftCols(k).transpose();
}

}  // namespace sheen
