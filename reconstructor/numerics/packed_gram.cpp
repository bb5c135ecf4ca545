// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/packed_gram.h"

#include <algorithm>

namespace sheen {
namespace {

bool diagonal_but_for(Eigen::Index block, const Eigen::MatrixXd& gram) {
  for (Eigen::Index k = 0; k < gram.cols(); ++k)
    for (Eigen::Index i = std::max(block, k + 1); i < gram.rows(); ++i)
      if (gram(i, k) != 0) return false;
  return true;
}

}  // namespace

PackedGram::PackedGram(const Eigen::MatrixXd& gram, Eigen::Index block)
    : block_(diagonal_but_for(block, gram) ? block : gram.rows()) {
  values_.reserve(static_cast<std::size_t>(block_ * (block_ + 1) / 2 + gram.rows() - block_));
  for (Eigen::Index k = 0; k < block_; ++k)
    for (Eigen::Index i = k; i < block_; ++i) values_.push_back(gram(i, k));
  for (Eigen::Index k = block_; k < gram.rows(); ++k) values_.push_back(gram(k, k));
}

Eigen::MatrixXd PackedGram::unpacked() const {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(size(), size());
  const double* next = values_.data();
  for (Eigen::Index k = 0; k < block_; ++k)
    for (Eigen::Index i = k; i < block_; ++i) gram(i, k) = gram(k, i) = *next++;
  for (Eigen::Index k = block_; k < gram.rows(); ++k) gram(k, k) = *next++;
  return gram;
}

Eigen::VectorXd PackedGram::diagonal() const {
  Eigen::VectorXd diagonal(size());
  const double* next = values_.data();
  for (Eigen::Index k = 0; k < diagonal.size(); ++k) {
    diagonal[k] = *next;
    next += k < block_ ? block_ - k : 1;
  }
  return diagonal;
}

}  // namespace sheen
