// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/registration/placement.h"

namespace sheen {

/// A point of the mesh and where it was found, with what is known of that up to a common factor.
struct PointPair {
  Eigen::Vector3d mesh, stage;
  Eigen::Matrix3d covariance;  ///< of `stage`, m^2
};

struct PointFit {
  Similarity stage_from_mesh;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();      ///< of the points used, stage frame
  PlacementMatrix covariance = PlacementMatrix::Zero();  ///< of a step about it, for a variance factor of 1
  double squares = 0;                                    ///< of the residuals, in their standard deviations
  int degrees_of_freedom = 0;
};

/// What a fit may do to the mesh's size.
struct ScaleRule {
  bool free = false;
  double scale = 1;  ///< where it is not free
};

/// Least squares over the pairs whose indices are given: Umeyama's closed form, then Gauss-Newton with the covariances
/// (which changes nothing where those are alike in all directions).
PointFit fit_points(std::span<const PointPair> pairs, std::span<const int> used, const ScaleRule& rule);

/// How far a pair is from where a fit has it, in standard deviations of that (RMS of the three directions); `factor`:
/// of the variances. `in_fit`: the fit rests on it, too.
double sigmas_off(const PointPair& pair, const PointFit& fit, double factor);

/// Variance factor of a fit, drawn to 1 as `prior` degrees of freedom would.
double variance_factor(const PointFit& fit, double prior);

/// Pairs that agree on one placement: from the three whose placement more than half of all agree with best, the
/// nearest is added as long as it is within `outlier_sigmas`. `known`: the covariances need no factor.
std::vector<int> consensus(std::span<const PointPair> pairs, const ScaleRule& rule, bool known, double outlier_sigmas);

}  // namespace sheen
