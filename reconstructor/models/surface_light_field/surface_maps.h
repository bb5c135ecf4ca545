// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>

#include "reconstructor/numerics/half.h"

namespace sheen {

/// Surface maps: rows (3 * samples) x terms. In single precision, or in half precision, which is what is drawn with.
class SurfaceMaps {
 public:
  SurfaceMaps() = default;
  SurfaceMaps(Eigen::MatrixXf values) : exact_(std::move(values)) {}
  template <typename Derived>
  SurfaceMaps(const Eigen::MatrixBase<Derived>& values) : exact_(values) {}
  static SurfaceMaps in_half(const Eigen::MatrixXf& values);

  Eigen::Index rows() const { return in_half_ ? rounded_.rows() : exact_.rows(); }
  Eigen::Index cols() const { return in_half_ ? rounded_.cols() : exact_.cols(); }
  Eigen::Index size() const { return rows() * cols(); }
  Eigen::MatrixXf values() const { return middle_rows(0, rows()); }
  Eigen::MatrixXf middle_rows(Eigen::Index first, Eigen::Index count) const;
  Eigen::VectorXf col(Eigen::Index term) const;
  /// What coefficients make of a sample.
  Eigen::Vector3f colour(Eigen::Index sample, const Eigen::Ref<const Eigen::VectorXf>& coefficients) const;
  std::size_t bytes() const;
  bool operator==(const SurfaceMaps& other) const;

 private:
  bool in_half_ = false;
  Eigen::MatrixXf exact_;
  RestingMatrix rounded_;
};

}  // namespace sheen
