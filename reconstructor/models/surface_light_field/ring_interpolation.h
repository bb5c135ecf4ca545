// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>

#include "reconstructor/models/surface_light_field/reflection_drift.h"
#include "reconstructor/models/surface_light_field/view_interpolation.h"
#include "reconstructor/models/surface_light_field/view_set.h"
#include "reconstructor/numerics/view_kriging.h"

namespace sheen {

/// How one ring interpolates between its views: the kernel that was chosen for it, the reflection that all rings share,
/// and when the choice is due again. `coefficients` are the views', a column each; `normal` is the vertex's.
class RingInterpolation {
 public:
  /// Rings of differing phase choose at different images, which spreads the work.
  explicit RingInterpolation(unsigned phase) : phase_(phase), due_(due_after(0)) {}

  const ViewInterpolation& chosen() const { return chosen_; }
  const std::shared_ptr<const ReflectionDrift>& reflection() const { return reflection_; }
  /// After `images` were ingested; from then on the next choice is due when they have grown by a factor.
  void choose(const ViewInterpolation& interpolation, int images);
  void share(std::shared_ptr<const ReflectionDrift> reflection) { reflection_ = std::move(reflection); }

  /// There are views enough to say how fast a ring varies.
  static bool can_choose(int views);
  bool due(int images) const { return images >= due_; }
  /// Errors with the drift are infinite while there is none, and with too few views.
  InterpolationErrors errors(const ViewSet& views, const Eigen::MatrixXf& coefficients,
                             const Eigen::Vector3f& normal) const;

  ViewInterpolant krige(const ViewSet& views, const Eigen::MatrixXf& coefficients, const Eigen::Vector3f& normal) const;
  /// The coefficients of an interpolant of these views as seen from a direction.
  Eigen::VectorXf at(const ViewInterpolant& interpolant, const ViewSet& views, const Eigen::Vector3f& direction,
                     const Eigen::Vector3f& normal) const;

 private:
  int due_after(int images) const;
  Eigen::VectorXf drift_of(const ViewSet& views, const Eigen::Vector3f& normal) const;

  ViewInterpolation chosen_;
  unsigned phase_;
  int due_;  ///< images ingested when the next choice is
  std::shared_ptr<const ReflectionDrift> reflection_;
};

}  // namespace sheen
