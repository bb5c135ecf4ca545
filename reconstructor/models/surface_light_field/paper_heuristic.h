// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reconstructor/models/surface_light_field/light_field_snapshot.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {

/// The paper's quality heuristic (000 sec. 3.3), which ours is compared with: Psi = omega sqrt(Psi_p^2 + Psi_h^2) of a
/// triangle from a direction, 0 = well known .. 1 = not known; omega = 1/sqrt(2). Psi_p is the smoothed relative
/// projection error of the online SVD, Psi_h the area of the Delaunay triangle round the direction on the view map,
/// each the mean over the triangle's vertices. Both scales are ours: the paper gives none.
class PaperHeuristic {
 public:
  /// `snapshot` must outlive this.
  /// `every`: only vertices 0, every, 2 every, ... can be asked for, in less time.
  explicit PaperHeuristic(const LightFieldSnapshot& snapshot, std::size_t every = 1);

  /// A triangle; 1 where one of its vertices shows nothing.
  std::vector<float> seen_from(const Eigen::Vector3d& eye) const;
  /// A vertex alone.
  float of_vertex(std::size_t vertex, const Eigen::Vector3d& eye) const;

 private:
  const LightFieldSnapshot& snapshot_;
  std::vector<ViewTriangulation> views_;  ///< per vertex
};

}  // namespace sheen
