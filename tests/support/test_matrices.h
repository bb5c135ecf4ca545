// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace sheen {

/// Gaussian entries from a seed.
inline Eigen::MatrixXf gaussian_matrix(int rows, int columns, std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<float> normal;
  return Eigen::MatrixXf::NullaryExpr(rows, columns, [&] { return normal(engine); });
}

/// A patch's data as it comes from a camera: positive colours times a level that varies with the view, a few smooth
/// terms of falling size, and noise of the given standard deviation relative to the mean colour.
inline Eigen::MatrixXf patch_like_matrix(int rows, int columns, int terms, float noise, std::uint32_t seed) {
  Eigen::MatrixXf data = (0.5f + 0.1f * gaussian_matrix(rows, 1, seed).array()).matrix() *
                         (1.0f + 0.1f * gaussian_matrix(1, columns, seed + 1).array()).matrix();
  float size = 0.2f;
  for (int t = 0; t < terms; ++t, size *= 0.6f)
    data += size * gaussian_matrix(rows, 1, seed + 10 + 2 * t) * gaussian_matrix(1, columns, seed + 11 + 2 * t);
  return data + 0.5f * noise * gaussian_matrix(rows, columns, seed + 5);
}

}  // namespace sheen
