// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/render/demand_map.h"
#include "reconstructor/render/gl/orbit_camera.h"
#include "reconstructor/render/gl/panel.h"
#include "reconstructor/render/guess_marks.h"

namespace sheen {

enum class SurfaceShading {
  kAppearance,  ///< what the camera would see; striped where no image reached: dark, or a guess
  kHeuristic,   ///< how much images are needed: see `need_color`
  kReasons,     ///< from the green of what is known to the colour of the reason: see `reason_color`
  kStates,      ///< kAppearance, tinted where samples are imputed or unseen: see `state_color`
  kPlain,       ///< the mesh in grey: all that there is before the first image
  kRank,        ///< what the scene required, as `DemandMap` has it: terms,
  kResolution,  ///< samples along a side of a map,
  kBytes,       ///< memory
  kShape,       ///< what of a found shape is known, and from what: see `evidence_color`
};

/// Of a shading that shows what the scene required.
std::optional<Demand> demand_of(SurfaceShading shading);

/// From green, nothing is needed, over yellow to red: 0..1, sRGB-encoded. `need`: 0..1, see
/// `SurfaceQuality::heuristic`.
Eigen::Vector3f need_color(float need);

/// Colour of a reason in `SurfaceShading::kReasons` and in its legend: 0..1, sRGB-encoded.
Eigen::Vector3f reason_color(QualityReason reason);

/// OpenCV camera -> OpenGL clip space: pixel centres of the camera fall on pixel centres of the panel.
Eigen::Matrix4f clip_from_object(const Viewpoint& view, const BoundingSphere& object);

struct DrawerOptions {
  /// Uploaded in one call of `update` at most, so that the window stays fluid; one patch at least.
  std::size_t texels_per_update = std::size_t(4) << 20;
  /// Bound of one GPU buffer in texels; 0 = what the driver allows.
  std::size_t max_buffer_texels = 0;
};

/// Where a drawer draws. What of the panel may be touched, the caller has set as the scissor.
struct DrawArea {
  Panel panel;
  int target_height = 0;  ///< of the whole target, pixels
  float pixel_size = 1;   ///< of the target's pixels in those of the window: patterns keep their size
};

/// Draws one kind of model with OpenGL 3.3. Made, used and destroyed with one context current.
class ModelDrawer {
 public:
  virtual ~ModelDrawer() = default;
  /// Brings what changed since the last call to the GPU, a bounded part of it per call: true when all of it is there;
  /// else what is still to come is drawn as it was, and the next call goes on. Null: nothing is drawn. Throws
  /// DeviceError when the mesh itself does not fit.
  virtual bool update(const std::shared_ptr<const ModelSnapshot>& snapshot) = 0;
  /// Draws with a depth test of its own; the background stays.
  virtual void draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) = 0;
  /// Whether the picture is from the viewpoint's eye; else it is always from that of the images.
  virtual bool follows_eye() const { return true; }
  /// What a person should know of the drawing, a line each: that the graphics memory is full, say.
  virtual std::vector<std::string> notes() const { return {}; }
};

}  // namespace sheen
