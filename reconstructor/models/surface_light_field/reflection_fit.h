// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "reconstructor/numerics/reflection_drift.h"

namespace sheen {

/// The level of a patch, its mean encoded colour, in each view.
struct PatchLevels {
  Eigen::Vector3f normal;
  Eigen::Matrix3Xf directions;  ///< to the eyes, one column per view
  Eigen::Matrix3Xf levels;      ///< RGB, encoded
  Eigen::VectorXf reliability;  ///< per view, > 0
};

/// Level of patch v in view j = mean of v + s_v (L(mirrored direction) - its mean over the views of v), by alternating
/// least squares for L and the sensitivities s_v (one per patch and channel), which are drawn halfway to the patch's
/// mean level: a dark patch varies less. A round at a time, so that no image waits for all of it.
class ReflectionFit {
 public:
  explicit ReflectionFit(std::span<const PatchLevels> patches);
  ~ReflectionFit();
  ReflectionFit(ReflectionFit&&) noexcept;
  ReflectionFit& operator=(ReflectionFit&&) noexcept;

  /// One round. True when it was the last.
  bool step();
  /// Null when the patches hold too little to say anything.
  std::shared_ptr<const ReflectionDrift> result() const { return drift_; }

 private:
  struct Centred;
  void solve_light();
  void solve_sensitivities();

  std::vector<Centred> patches_;
  std::shared_ptr<ReflectionDrift> drift_;
  int rounds_left_ = 0;
};

/// All rounds at once.
std::shared_ptr<const ReflectionDrift> estimate_reflection_drift(std::span<const PatchLevels> patches);

}  // namespace sheen
