// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/registration/placement.h"

namespace sheen {

/// What one image says of a placement: robust least squares, linearised.
struct ImageEquations {
  PlacementMatrix information = PlacementMatrix::Zero();  ///< sum of w J^T J
  PlacementStep gradient = PlacementStep::Zero();         ///< sum of w J^T r
  double loss = 0;                                        ///< sum of the robust losses
  /// What the loss is divided by: what it would be if nothing agreed. It can depend on the placement, too: half of its
  /// derivative.
  double scale = 0;
  PlacementStep scale_gradient = PlacementStep::Zero();
  /// Derivative of `gradient` by an error that all residuals have in common.
  PlacementStep common = PlacementStep::Zero();
  std::size_t residuals = 0;

  template <int Rows>
  void add(double w, const Eigen::Matrix<double, Rows, 7>& j, const Eigen::Matrix<double, Rows, 1>& r) {
    information += w * j.transpose() * j;
    gradient += w * j.transpose() * r;
    common += w * j.transpose() * Eigen::Matrix<double, Rows, 1>::Ones();
    ++residuals;
  }
  ImageEquations& operator+=(const ImageEquations& other);
};

/// Of the images: every other one. Two halves know nothing of each other, and their difference tells what a fit is
/// worth.
enum class Half : std::uint8_t { kEven, kOdd, kBoth };
inline bool in_half(std::size_t image, Half half) {
  return half == Half::kBoth || (image % 2 == 0) == (half == Half::kEven);
}

using Equations = std::function<std::vector<ImageEquations>(const Similarity& stage_from_mesh)>;

struct FitOptions {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of the mesh as it stands
  double radius = 1;                                 ///< of the mesh, metres: makes angles and scales lengths
  bool free_scale = false;
  std::vector<int> groups;    ///< of each image: its group; empty: each its own
  double probe_m = 1e-4;      ///< what the surface is moved by to see how the gradient changes: about half a pixel
  double reach_m = HUGE_VAL;  ///< how far the surface may go from the start in all
  int most_steps = 30;
  double enough_m = 2e-6;    ///< a step that moves the surface by less is the last
  double common_error = 0;   ///< standard deviation of what all residuals get wrong alike
  double common_move_m = 0;  ///< standard deviation of a move of the surface that all images agree on and is wrong
};

struct PlacementFit {
  Similarity stage_from_mesh;
  /// From how much groups of images disagree: A^-1 (sum of g g^T over groups) A^-1, A the second derivative of the
  /// loss, g the gradients (Huber's sandwich with a group as the unit: what is wrong from one side is wrong in all that
  /// is seen from there). A is measured by differences of the gradient: noise in the images adds to J^T J and bends
  /// nothing. A direction that the images do not determine has the variance of the mesh's radius.
  PlacementMatrix covariance = PlacementMatrix::Zero();
  int undetermined = 0;       ///< such directions
  double cost = 0;            ///< per residual
  std::size_t residuals = 0;  ///< 0: the images say nothing, and the placement is the one that was given
};

/// Levenberg-Marquardt from `start`.
PlacementFit fit_placement(const Similarity& start, const Equations& equations, const FitOptions& options);

}  // namespace sheen
