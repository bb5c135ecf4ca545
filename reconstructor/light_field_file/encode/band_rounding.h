// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace sheen {

/// Rounds the frequencies of a map, tile by tile, so that squared error and bits together cost least. What a value
/// costs is estimated by how large its like are, the way the coder will expect it: a lone value is worth less than one
/// among others. A reader need not know.
class BandRounding {
 public:
  /// `bit_price`: squared steps that a bit is worth.
  explicit BandRounding(float bit_price) : bit_price_(bit_price) {}

  /// `frequencies` of a tile in steps, the smoothest first; `colour` 0, 1 or 2. As far as one is not zero.
  std::vector<std::int32_t> rounded(const Eigen::Ref<const Eigen::VectorXf>& frequencies, int colour);

 private:
  float expected(const Eigen::Ref<const Eigen::VectorXf>& frequencies, const std::vector<std::int32_t>& before,
                 const std::vector<float>& past) const;

  float bit_price_;
  std::array<std::vector<float>, 3> past_;  ///< by colour: mean sizes of each frequency in the tiles before
};

}  // namespace sheen
