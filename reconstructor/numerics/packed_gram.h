// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace sheen {

/// A symmetric matrix that is diagonal but for a leading block: the lower triangle of the block, and what is left of
/// the diagonal.
class PackedGram {
 public:
  PackedGram() = default;
  /// `block`: side of the leading block, where all else is diagonal; otherwise the block is the whole matrix. Of the
  /// two triangles, which rounding may have told apart, the lower one is kept.
  PackedGram(const Eigen::MatrixXd& gram, Eigen::Index block);

  bool empty() const { return values_.empty(); }
  Eigen::MatrixXd unpacked() const;
  Eigen::VectorXd diagonal() const;
  std::size_t bytes() const { return sizeof(double) * values_.capacity(); }

 private:
  Eigen::Index size() const { return block_ + static_cast<Eigen::Index>(values_.size()) - block_ * (block_ + 1) / 2; }

  Eigen::Index block_ = 0;
  std::vector<double> values_;  ///< column by column of the block's triangle; the diagonal behind it
};

}  // namespace sheen
