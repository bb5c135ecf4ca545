// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>

#include "reconstructor/numerics/reflection_drift.h"
#include "reconstructor/numerics/view_kernel.h"
#include "reconstructor/numerics/view_kriging.h"

namespace sheen {

/// From where triangles round a vertex were seen, and how what lies between is interpolated. Patches of which the same
/// images showed something share it.
struct VertexViews {
  Eigen::Matrix3Xf directions;  ///< unit vectors from the vertex to the cameras, object frame; a column per view
  Eigen::VectorXf reliability;  ///< per view, > 0: the kernel's nugget is divided by it
  std::shared_ptr<const ReflectionDrift> reflection;  ///< what all patches share; null where the vertex does without
  BelievedDrift believed;                             ///< what the views make of the reflection; of none without
  ViewKernel kernel;
  Eigen::Matrix3f frame;  ///< of the vertex's hemisphere
  float best_cosine = 0;  ///< of the most frontal view: cos of the angle to the vertex normal

  /// Finds `believed` where there is a reflection; from all else, which must be there.
  void believe_reflection();
  /// The reflection as far as it is believed, in a unit direction of which `covariances` are those to the views; 0
  /// without.
  float reflected(const Eigen::Vector3f& direction, const Eigen::VectorXf& covariances) const {
    return reflection ? believed.at(reflection->at(direction, frame.row(2)), covariances) : 0;
  }

  std::size_t bytes() const {
    return sizeof(*this) +
           sizeof(float) * static_cast<std::size_t>(directions.size() + reliability.size() + believed.weights.size());
  }
};

}  // namespace sheen
