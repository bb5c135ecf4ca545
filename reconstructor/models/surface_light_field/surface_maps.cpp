// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/surface_maps.h"

namespace sheen {

SurfaceMaps SurfaceMaps::in_half(const Eigen::MatrixXf& values) {
  SurfaceMaps maps;
  maps.in_half_ = true;
  maps.rounded_.put(values);
  return maps;
}

Eigen::MatrixXf SurfaceMaps::middle_rows(Eigen::Index first, Eigen::Index count) const {
  if (!in_half_) return exact_.middleRows(first, count);
  Eigen::MatrixXf values(count, cols());
  for (Eigen::Index k = 0; k < cols(); ++k) from_half(rounded_.column(k) + first, count, values.col(k).data());
  return values;
}

Eigen::VectorXf SurfaceMaps::col(Eigen::Index term) const {
  if (!in_half_) return exact_.col(term);
  Eigen::VectorXf values(rows());
  from_half(rounded_.column(term), rows(), values.data());
  return values;
}

Eigen::Vector3f SurfaceMaps::colour(Eigen::Index sample, const Eigen::Ref<const Eigen::VectorXf>& coefficients) const {
  if (!in_half_) return exact_.middleRows<3>(3 * sample).lazyProduct(coefficients);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (Eigen::Index k = 0; k < coefficients.size(); ++k) {
    const Half* value = rounded_.column(k) + 3 * sample;
    for (int c = 0; c < 3; ++c) sum[c] += static_cast<float>(value[c]) * coefficients[k];
  }
  return sum;
}

std::size_t SurfaceMaps::bytes() const {
  return sizeof(float) * static_cast<std::size_t>(exact_.size()) + rounded_.bytes();
}

bool SurfaceMaps::operator==(const SurfaceMaps& other) const {
  return rows() == other.rows() && cols() == other.cols() && values() == other.values();
}

}  // namespace sheen
