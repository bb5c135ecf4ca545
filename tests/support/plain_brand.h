// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sheen {

struct PlainBrandOptions {
  int cap = 12;          ///< terms that are kept
  double tolerance = 0;  ///< a rest below this norm is no direction (absolute, as published codes have it)
  /// What happens to a new direction when the cap is reached: the least of cap + 1 terms is dropped, or the direction
  /// itself, after which the span never changes again.
  bool freezes = false;
};

/// The textbook to compare with: Brand's update of a thin SVD (Fast low-rank modifications of the thin SVD, 2006), in
/// double precision, U and V rotated with every column, one projection, no care for orthogonality.
class PlainBrand {
 public:
  PlainBrand(int rows, const PlainBrandOptions& options) : options_(options), u_(rows, 0), v_(0, 0) {}

  void add(const Eigen::VectorXd& column);

  const Eigen::MatrixXd& u() const { return u_; }                ///< rows x k
  const Eigen::VectorXd& singular_values() const { return s_; }  ///< k
  const Eigen::MatrixXd& v() const { return v_; }                ///< columns x k
  /// U S V^T of the `rank` first terms.
  Eigen::MatrixXd model(int rank) const;

 private:
  PlainBrandOptions options_;
  Eigen::MatrixXd u_;
  Eigen::VectorXd s_;
  Eigen::MatrixXd v_;
};

}  // namespace sheen
