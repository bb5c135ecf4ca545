// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/geometry/mesh.h"
#include "reconstructor/numerics/view_kriging.h"

namespace sheen {

enum class ViewMethod {
  kKriging,
  kDelaunay,  ///< the paper's (000 sec. 4.2), for comparison: `delaunay_weights`
};

/// What rings may choose from. Other than the default it is for studies of what the parts are worth.
struct ViewInterpolationOptions {
  ViewMethod method = ViewMethod::kKriging;
  bool drift = true;        ///< the reflection that all rings share
  bool exponential = true;  ///< exponential kernels, beside those of Matern
  bool neighbours = true;   ///< errors of neighbouring rings count in a ring's choice
};

/// How a ring interpolates between its views: by a kernel of kViewKernels, with the drift that all rings share or
/// without.
struct ViewInterpolation {
  ViewKernel kernel;
  bool drift = false;
  bool operator==(const ViewInterpolation&) const = default;
};

/// Errors of predicting each view of a ring from the others, relative to the least: each kernel without the drift, then
/// each with it (infinite where there is none, or too few views for it).
using InterpolationErrors = std::array<float, 2 * kViewKernels.size()>;

/// Arguments as of `krige`.
InterpolationErrors interpolation_errors(const Eigen::Matrix3Xf& directions,
                                         const Eigen::Ref<const Eigen::MatrixXf>& coefficients,
                                         const Eigen::Ref<const Eigen::VectorXf>& reliability,
                                         const Eigen::VectorXf& drift);

/// Chooses for a ring by its own errors and its neighbours', and by those of all rings: its own are noisy with few
/// views, and what lies side by side varies alike.
class InterpolationChoice {
 public:
  /// Rings are the vertices of the mesh.
  explicit InterpolationChoice(const Mesh& mesh, const ViewInterpolationOptions& options = {});

  /// A ring's errors, in place of those that it had before.
  void count(std::uint32_t ring, const InterpolationErrors& errors);
  /// The ring must have been counted.
  ViewInterpolation choose(std::uint32_t ring) const;
  void clear();

 private:
  ViewInterpolationOptions options_;
  std::vector<std::uint32_t> first_neighbour_, neighbours_;  ///< of ring v: neighbours_[first_neighbour_[v]] and on
  std::vector<std::optional<InterpolationErrors>> latest_;   ///< per ring
  std::array<double, 2 * kViewKernels.size()> all_{};        ///< sum over all that were counted
};

}  // namespace sheen
