// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/view_interpolation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace sheen {
namespace {

constexpr std::size_t kKernels = kViewKernels.size();

constexpr double kOwnWeight = 3;  // of a ring and its neighbours against all rings
// What single precision may leave of a squared error that is none, a coefficient that reaches 1: such are alike.
constexpr double kRounding = 1e-13;

template <typename Errors>
double least(const Errors& errors) {
  return *std::min_element(errors.begin(), errors.end());
}

/// A ring that could not try the drift says nothing for it nor against it.
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

InterpolationChoice::InterpolationChoice(const Mesh& mesh, const ViewInterpolationOptions& options)
    : options_(options), latest_(mesh.vertices.size()) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& triangle : mesh.triangles)
    for (int c = 0; c < 3; ++c) {
      edges.emplace_back(triangle[c], triangle[(c + 1) % 3]);
      edges.emplace_back(triangle[(c + 1) % 3], triangle[c]);
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  first_neighbour_.assign(mesh.vertices.size() + 1, 0);
  for (const auto& [from, to] : edges) {
    ++first_neighbour_[from + 1];
    neighbours_.push_back(to);
  }
  std::partial_sum(first_neighbour_.begin(), first_neighbour_.end(), first_neighbour_.begin());
}

void InterpolationChoice::count(std::uint32_t ring, const InterpolationErrors& errors) {
  latest_[ring] = errors;
  for (std::size_t k = 0; k < all_.size(); ++k) all_[k] += error_of(errors, k);
}

ViewInterpolation InterpolationChoice::choose(std::uint32_t ring) const {
  std::array<double, 2 * kKernels> near{};
  double rings = 1;
  std::copy(latest_[ring]->begin(), latest_[ring]->end(), near.begin());  // infinite where it cannot have the drift
  for (std::uint32_t i = first_neighbour_[ring]; options_.neighbours && i < first_neighbour_[ring + 1]; ++i) {
    const std::optional<InterpolationErrors>& neighbour = latest_[neighbours_[i]];
    if (!neighbour) continue;
    ++rings;
    for (std::size_t k = 0; k < near.size(); ++k) near[k] += error_of(*neighbour, k);
  }
  const double best_of_all = least(all_);
  const auto cost = [&](std::size_t k) {
    if (!options_.exponential && kViewKernels[k % kKernels].shape == KernelShape::kExponential)
      return std::numeric_limits<double>::infinity();
    return kOwnWeight * near[k] / rings + all_[k] / best_of_all;
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
