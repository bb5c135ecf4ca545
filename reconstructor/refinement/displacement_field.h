// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "reconstructor/refinement/vertex_patches.h"

namespace sheen {

/// What is observed of each vertex's displacement along its normal: the diagonal normal equations
/// information * u = information * value. An information of 0: nothing was observed.
struct Observations {
  Eigen::VectorXd value;        ///< metres
  Eigen::VectorXd information;  ///< 1 / variance, 1/m^2

  explicit Observations(Eigen::Index vertices = 0)
      : value(Eigen::VectorXd::Zero(vertices)), information(Eigen::VectorXd::Zero(vertices)) {}
  /// Adds an independent observation.
  void add(Eigen::Index vertex, double observed, double with_information);
  void add(const Observations& others);
};

/// What is known of a displacement before anything is observed: neighbours move alike, and none moves far.
struct DisplacementPrior {
  double stiffness = 0;  ///< 1 / variance of the difference along an edge, 1/m^2
  double ridge = 0;      ///< 1 / variance of a displacement, 1/m^2; above 0
};

struct DisplacementField {
  Eigen::VectorXd value;     ///< metres; the most probable one
  Eigen::VectorXd variance;  ///< m^2; empty where it was not asked for
};

/// The minimum of
///   sum_sources sum_v information_v rho(u_v - value_v) + stiffness sum_edges (u_a - u_b)^2 + ridge sum_v u_v^2,
/// rho quadratic near 0 and Cauchy's for what contradicts its neighbours, or another source, by several standard
/// deviations. The variance is the diagonal of the inverse of the normal equations at the minimum. `sources`: one or
/// more, independent of each other.
DisplacementField most_probable_field(const MeshEdges& edges, std::span<const Observations> sources,
                                      const DisplacementPrior& prior, bool with_variance);

/// Gives the vertices of which nothing is observed the values that vary least over the edges (a harmonic function)
/// between those of the others; 0 where no edges lead to one of them.
void continue_smoothly(const MeshEdges& edges, const Observations& observed, Eigen::VectorXd& values);

/// The prior with which each half predicts the other best. Both halves observe the same displacement.
DisplacementPrior cross_validated(const MeshEdges& edges, const Observations& first, const Observations& second,
                                  std::span<const DisplacementPrior> priors);

}  // namespace sheen
