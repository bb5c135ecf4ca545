// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "reconstructor/numerics/view_kriging.h"

namespace sheen {

/// How a ring interpolates between its views: by a kernel of kViewKernels, with the drift that all rings share or
/// without.
struct ViewInterpolation {
  ViewKernel kernel;
  bool drift = false;
  bool operator==(const ViewInterpolation&) const = default;
};

/// Errors of predicting each view of a ring from the others, relative to the least: each kernel without the drift, then
/// each with it (infinite where there is none, or too few views for it).
using InterpolationErrors = std::array<double, 2 * kViewKernels.size()>;

/// Arguments as of `krige`.
InterpolationErrors interpolation_errors(const Eigen::Matrix3Xf& directions,
                                         const Eigen::Ref<const Eigen::MatrixXf>& coefficients,
                                         const Eigen::Ref<const Eigen::VectorXf>& reliability,
                                         const Eigen::VectorXf& drift);

/// Chooses for a ring by its own errors and those of all rings: its own are noisy with few views.
class InterpolationChoice {
 public:
  void count(const InterpolationErrors& errors);
  ViewInterpolation choose(const InterpolationErrors& own) const;

 private:
  InterpolationErrors all_{};
};

}  // namespace sheen
