// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "reconstructor/models/surface_quality.h"

namespace sheen {

class LightFieldSnapshot;

inline constexpr double kInSight = 0.2;  ///< cosine: what is turned away further is not in sight

/// What the person who holds the camera is led by.
enum class GuidanceMethod {
  kExpectedError,   ///< the error that kriging expects (docs/decisions/quality.md), and `image_worth`
  kPaperHeuristic,  ///< the paper's (000 sec. 3.3), `PaperHeuristic`, and its mean over the surface in sight
};

/// What leads the person who holds the camera: how well the surface is known, which the window paints red, and what one
/// more image is worth. Thread-safe.
class CaptureGuidance {
 public:
  virtual ~CaptureGuidance() = default;
  /// How well a vertex is known from an eye (object frame).
  virtual SurfaceQuality of_vertex(std::size_t vertex, const Eigen::Vector3d& eye) const = 0;
  /// The same of every triangle.
  virtual std::vector<SurfaceQuality> of_triangles(const Eigen::Vector3d& eye) const = 0;
  /// What one more image from each of these places is worth, in arbitrary units; 0 = nothing.
  virtual std::vector<double> worth(std::span<const Eigen::Vector3d> eyes) const = 0;
};

/// By the method that the snapshot's scene asks for. `snapshot` must outlive it. `every`: only vertices 0, every,
/// 2 every, ... and worths can be asked for, in less time.
std::unique_ptr<const CaptureGuidance> make_guidance(const LightFieldSnapshot& snapshot, std::size_t every = 1);

}  // namespace sheen
