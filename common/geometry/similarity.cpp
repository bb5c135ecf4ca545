// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/similarity.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace sheen {

Similarity fit_similarity(std::span<const Eigen::Vector3d> source, std::span<const Eigen::Vector3d> target,
                          std::span<const double> weights) {
  const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };
  Eigen::Vector3d source_mean = Eigen::Vector3d::Zero(), target_mean = Eigen::Vector3d::Zero();
  double total = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    source_mean += weight(i) * source[i];
    target_mean += weight(i) * target[i];
    total += weight(i);
  }
  source_mean /= total;
  target_mean /= total;
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  double source_spread = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    correlation += weight(i) * (target[i] - target_mean) * (source[i] - source_mean).transpose();
    source_spread += weight(i) * (source[i] - source_mean).squaredNorm();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV()).determinant() < 0 ? -1 : 1);  // no mirror image
  Similarity fit;
  fit.rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  fit.scale = svd.singularValues().dot(signs) / source_spread;
  fit.translation = target_mean - fit.scale * (fit.rotation * source_mean);
  return fit;
}

}  // namespace sheen
