// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"
#include "reconstructor/models/appearance_model.h"

namespace sheen {

// `PaintedView::coverage`; 0 where there is no surface. A triangle's back is unseen: its colour is that of its front.
inline constexpr std::uint8_t kCoverageUnseen = 128, kCoverageImputed = 192, kCoverageMeasured = 255;

/// A picture of a model with what is known about each pixel.
struct PaintedView {
  ImageF beauty;           ///< linear RGB; 0 where there is no surface
  ImageU8 coverage;        ///< the SampleState of what is shown, as kCoverage...; 0 where there is no surface
  ImageF predicted_error;  ///< 1 channel: RMS of encoded values by which the picture is expected to be wrong
  ImageF heuristic;        ///< 1 channel, 0..1
  ImageU8 reason;          ///< QualityReason + 1; 0 where there is no surface
};

/// Ray-casts a model's snapshot through a real camera, lens distortion included: one ray per pixel through its centre.
/// Needs no GPU and no display. Thread-safe.
class RayPainter {
 public:
  explicit RayPainter(const Mesh& mesh) : scene_(mesh) {}

  /// The snapshot must be of the painter's mesh. `light` and `more_lights`: as in `ViewQuery`.
  PaintedView paint(const Appearance& snapshot, const Camera& camera, const Rigid3& camera_from_object,
                    const LightState& light = {}, std::vector<LightState> more_lights = {}) const;

  /// First hits of all pixels, row by row.
  std::vector<Hit> cast(const Camera& camera, const Rigid3& camera_from_object) const;

 private:
  RayScene scene_;
};

}  // namespace sheen
