// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"
#include "reconstructor/models/appearance_model.h"
#include "reconstructor/render/outlines.h"

namespace sheen {

// `PaintedView::coverage`; 0 where there is no surface.
inline constexpr std::uint8_t kCoverageUnseen = 128, kCoverageImputed = 192, kCoverageMeasured = 255;

/// A picture of a model with what is known about each pixel.
struct PaintedView {
  ImageF beauty;           ///< linear RGB; 0 where there is no surface
  ImageU8 coverage;        ///< the SampleState of what is shown, as kCoverage...; 0 where there is no surface
  ImageF predicted_error;  ///< 1 channel: RMS of encoded values by which the picture is expected to be wrong
  ImageF heuristic;        ///< 1 channel, 0..1
  ImageU8 reason;          ///< QualityReason + 1; 0 where there is no surface
};

/// A picture with smooth outlines, to be laid over any background: where an outline runs through a pixel, `beauty` is
/// the mean over that part of the pixel's square that shows surface, not mixed with black (straight alpha). All else is
/// what the ray through the pixel's centre meets.
struct SmoothView : PaintedView {
  ImageF alpha;  ///< 1 channel: the part of each pixel's square that shows surface, 0..1
};

/// Linear colours times alpha, with alpha as the fourth channel.
ImageF premultiplied(const SmoothView& view);
/// 8-bit sRGB of the colours as they are, with alpha (linear) as the fourth channel.
ImageU8 straight_srgb8(const SmoothView& view);

/// Ray-casts a model's snapshot through a real camera, lens distortion included: one ray per pixel through its centre.
/// Needs no GPU and no display. Thread-safe.
class RayPainter {
 public:
  explicit RayPainter(const Mesh& mesh) : scene_(std::make_shared<const RayScene>(mesh)) {}

  /// Of the mesh.
  const std::shared_ptr<const RayScene>& scene() const { return scene_; }

  /// The snapshot must be of the painter's mesh. `light` and `more_lights`: as in `ViewQuery`.
  PaintedView paint(const Appearance& snapshot, const Camera& camera, const Rigid3& camera_from_object,
                    const LightState& light = {}, std::vector<LightState> more_lights = {}) const;

  /// The same with smooth outlines, which must be those of the painter's mesh: 16 rays where one runs.
  SmoothView paint_smooth(const Appearance& snapshot, const Outlines& outlines, const Camera& camera,
                          const Rigid3& camera_from_object, const LightState& light = {}) const;

  /// 255 where the first hit is a front face.
  ImageU8 silhouette(const Camera& camera, const Rigid3& camera_from_object) const;

  /// First hits of all pixels, row by row.
  std::vector<Hit> cast(const Camera& camera, const Rigid3& camera_from_object) const;

 private:
  /// Of one row of pixels.
  void cast_row(const Camera& camera, const Rigid3& object_from_camera, int y, std::span<Hit> hits) const;
  PaintedView paint(const ViewShader& shader, const Camera& camera, const Rigid3& camera_from_object) const;

  std::shared_ptr<const RayScene> scene_;
};

}  // namespace sheen
