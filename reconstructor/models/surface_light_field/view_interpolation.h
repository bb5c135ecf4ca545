// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "reconstructor/light_field_file/patch_shapes.h"
#include "reconstructor/numerics/view_kriging.h"

namespace sheen {

enum class ViewMethod {
  kKriging,
  kDelaunay,  ///< the paper's (000 sec. 4.2), for comparison: `delaunay_weights`
};

/// What vertices may choose from. Other than the default it is for studies of what the parts are worth.
struct ViewInterpolationOptions {
  ViewMethod method = ViewMethod::kKriging;
  bool drift = true;        ///< the reflection that all patches share
  bool exponential = true;  ///< exponential kernels, beside those of Matern
};

/// How views are interpolated at a vertex: by a kernel of kViewKernels, with the drift that all patches share or
/// without.
struct ViewInterpolation {
  ViewKernel kernel;
  bool drift = false;
  bool operator==(const ViewInterpolation&) const = default;
};

/// Errors of predicting each view of a patch from the others, relative to the least: each kernel without the drift,
/// then each with it (infinite where there is none, or too few views for it).
using InterpolationErrors = std::array<float, 2 * kViewKernels.size()>;

/// Arguments as of `krige`.
InterpolationErrors interpolation_errors(const Eigen::Matrix3Xf& directions,
                                         const Eigen::Ref<const Eigen::MatrixXf>& coefficients,
                                         const Eigen::Ref<const Eigen::VectorXf>& reliability,
                                         const Eigen::VectorXf& drift);

/// Chooses for a vertex by the errors of the patches round it, and by those of all patches: those near are noisy with
/// few views, and what lies side by side varies alike.
class InterpolationChoice {
 public:
  explicit InterpolationChoice(std::shared_ptr<const PatchShapes> shapes, const ViewInterpolationOptions& options = {});

  std::size_t vertices() const { return shapes_->first_round.size() - 1; }
  /// A patch's errors, in place of those that it had before.
  void count(std::uint32_t patch, const InterpolationErrors& errors);
  bool counted(std::uint32_t patch) const { return latest_[patch].has_value(); }
  bool can_choose(std::uint32_t vertex) const;  ///< one of the patches round the vertex was counted
  /// The vertex must be able to.
  ViewInterpolation choose(std::uint32_t vertex) const;
  void clear();
  void use(std::shared_ptr<const PatchShapes> shapes) { shapes_ = std::move(shapes); }  ///< the same, on other maps

 private:
  std::shared_ptr<const PatchShapes> shapes_;
  ViewInterpolationOptions options_;
  std::vector<std::optional<InterpolationErrors>> latest_;  ///< per patch
  std::array<double, 2 * kViewKernels.size()> all_{};       ///< sum over all that were counted
};

}  // namespace sheen
