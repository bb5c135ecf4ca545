// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/view_interpolation.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr std::size_t kKernels = kViewKernels.size();

double least(const InterpolationErrors& errors) {
  return std::max(*std::min_element(errors.begin(), errors.end()), 1e-30);
}

}  // namespace

InterpolationErrors interpolation_errors(const Eigen::Matrix3Xf& directions,
                                         const Eigen::Ref<const Eigen::MatrixXf>& coefficients,
                                         const Eigen::Ref<const Eigen::VectorXf>& reliability,
                                         const Eigen::VectorXf& drift) {
  InterpolationErrors errors{};
  for (std::size_t k = 0; k < kKernels; ++k) {
    const LeaveOneOut error = leave_one_out(directions, coefficients, reliability, kViewKernels[k], drift);
    errors[k] = error.ordinary;
    errors[kKernels + k] = error.with_drift;
  }
  const double best = least(errors);
  for (double& error : errors) error /= best;
  return errors;
}

void InterpolationChoice::count(const InterpolationErrors& errors) {
  for (std::size_t k = 0; k < kKernels; ++k) {
    all_[k] += errors[k];
    // A ring that could not try the drift says nothing for it nor against it.
    all_[kKernels + k] += std::isfinite(errors[kKernels + k]) ? errors[kKernels + k] : errors[k];
  }
}

ViewInterpolation InterpolationChoice::choose(const InterpolationErrors& own) const {
  const double best_of_all = least(all_);
  std::size_t chosen = 0;
  for (std::size_t k = 1; k < own.size(); ++k)
    if (own[k] + all_[k] / best_of_all < own[chosen] + all_[chosen] / best_of_all) chosen = k;
  return {kViewKernels[chosen % kKernels], chosen >= kKernels};
}

}  // namespace sheen
