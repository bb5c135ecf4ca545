// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reconstructor/surface/map_layout.h"

namespace sheen {

/// Carries values from a triangle's lattice of one resolution to one of another, by linear interpolation. So what
/// stands on more samples draws the same surface, and what stands on fewer is right at each of them, whatever lies
/// between. Holds tables as long as the lattices: made where it is used, and not kept.
class LatticeResampling {
 public:
  LatticeResampling(int from, int to);

  /// 3 x samples of the one, to 3 x samples of the other.
  Eigen::Matrix3Xf of(const Eigen::Ref<const Eigen::Matrix3Xf>& values) const;
  /// What linear interpolation between the carried values misses of those they come from.
  Eigen::Matrix3Xf missed(const Eigen::Ref<const Eigen::Matrix3Xf>& values) const;
  /// The same of one value for each sample.
  Eigen::VectorXf of_plane(const Eigen::Ref<const Eigen::VectorXf>& values) const;
  Eigen::VectorXf missed_of_plane(const Eigen::Ref<const Eigen::VectorXf>& values) const;
  /// The old samples round a new one, with their weights.
  const LatticeStencil& round(int sample) const { return at_new_[static_cast<std::size_t>(sample)]; }

  /// Of these the one that weighs most.
  int nearest(int sample) const;

 private:
  std::vector<LatticeStencil> at_new_;  ///< of the old lattice, at each new sample
  std::vector<LatticeStencil> at_old_;  ///< of the new lattice, at each old sample
};

}  // namespace sheen
