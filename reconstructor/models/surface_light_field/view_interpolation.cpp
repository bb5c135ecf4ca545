// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/view_interpolation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace sheen {
namespace {

constexpr std::size_t kKernels = kViewKernels.size();

constexpr double kNearWeight = 3;  // of the patches round a vertex against all patches
// What single precision may leave of a squared error that is none, a coefficient that reaches 1: such are alike.
constexpr double kRounding = 1e-13;

template <typename Errors>
double least(const Errors& errors) {
  return *std::min_element(errors.begin(), errors.end());
}

/// A patch that could not try the drift says nothing for it nor against it.
double error_of(const InterpolationErrors& errors, std::size_t k) {
  return std::isfinite(errors[k]) ? errors[k] : errors[k - kKernels];
}

}  // namespace

InterpolationErrors interpolation_errors(const Eigen::Matrix3Xf& directions,
                                         const Eigen::Ref<const Eigen::MatrixXf>& coefficients,
                                         const Eigen::Ref<const Eigen::VectorXf>& reliability,
                                         const Eigen::VectorXf& drift) {
  const Eigen::MatrixXf angles = angles_between(directions);
  const float peak = std::max(coefficients.lpNorm<Eigen::Infinity>(), std::numeric_limits<float>::min());
  const Eigen::MatrixXf scaled = coefficients / peak;  // whose squares neither overflow nor vanish
  std::array<double, 2 * kKernels> errors{};
  for (std::size_t k = 0; k < kKernels; ++k) {
    const LeaveOneOut error = leave_one_out<float>(angles, scaled, reliability, kViewKernels[k], drift);
    errors[k] = error.ordinary;
    errors[kKernels + k] = error.with_drift;
  }
  const double best = least(errors), rounding = kRounding * static_cast<double>(1 + coefficients.size());
  InterpolationErrors relative{};
  std::transform(errors.begin(), errors.end(), relative.begin(),
                 [&](double e) { return static_cast<float>((e + rounding) / (best + rounding)); });
  return relative;
}

InterpolationChoice::InterpolationChoice(std::shared_ptr<const PatchShapes> shapes,
                                         const ViewInterpolationOptions& options)
    : shapes_(std::move(shapes)), options_(options), latest_(shapes_->patches.size()) {}

void InterpolationChoice::count(std::uint32_t patch, const InterpolationErrors& errors) {
  std::optional<InterpolationErrors>& latest = latest_[patch];
  for (std::size_t k = 0; k < all_.size(); ++k) all_[k] += error_of(errors, k) - (latest ? error_of(*latest, k) : 0.0);
  latest = errors;
}

bool InterpolationChoice::can_choose(std::uint32_t vertex) const {
  const std::span<const PatchVertex> round = shapes_->round(vertex);
  return std::any_of(round.begin(), round.end(), [&](const PatchVertex& at) { return counted(at.patch); });
}

ViewInterpolation InterpolationChoice::choose(std::uint32_t vertex) const {
  std::array<double, 2 * kKernels> near{};
  double patches = 0, tried_drift = 0;
  for (const PatchVertex& round : shapes_->round(vertex)) {
    const std::optional<InterpolationErrors>& errors = latest_[round.patch];
    if (!errors) continue;
    ++patches;
    tried_drift += std::isfinite((*errors)[kKernels]);
    for (std::size_t k = 0; k < near.size(); ++k) near[k] += error_of(*errors, k);
  }
  const bool drift = 2 * tried_drift > patches;  // fewer, with the least views that allow for it, promise too much
  const double best_of_all = least(all_);
  const auto cost = [&](std::size_t k) {
    if ((k >= kKernels && !drift) ||
        (!options_.exponential && kViewKernels[k % kKernels].shape == KernelShape::kExponential))
      return std::numeric_limits<double>::infinity();
    return kNearWeight * near[k] / patches + all_[k] / best_of_all;
  };
  std::size_t chosen = 0;
  for (std::size_t k = 1; k < near.size(); ++k)
    if (cost(k) < cost(chosen)) chosen = k;
  return {kViewKernels[chosen % kKernels], chosen >= kKernels};
}

void InterpolationChoice::clear() {
  std::fill(latest_.begin(), latest_.end(), std::nullopt);
  all_ = {};
}

}  // namespace sheen
