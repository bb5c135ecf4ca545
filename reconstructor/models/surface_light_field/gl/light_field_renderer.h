// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "reconstructor/models/surface_light_field/gl/basis_store.h"
#include "reconstructor/models/surface_light_field/snapshot.h"
#include "reconstructor/render/gl/gl_objects.h"
#include "reconstructor/render/gl/orbit_camera.h"

namespace sheen {

/// A rectangle of the picture in pixels from its top left corner.
struct Panel {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Panel&) const = default;
};

enum class SurfaceShading {
  kLightField,  ///< what the camera would see; striped where no image reached: dark, or a guess
  kHeuristic,   ///< the brighter the red, the more images are needed
  kReasons,     ///< a colour a reason, as bright as the need: see `reason_color`
  kStates,      ///< kLightField, tinted where samples are imputed or unseen: see `state_color`
  kPlain,       ///< the mesh in grey: all that there is before the first image
};

/// Colour of a reason in `SurfaceShading::kReasons` and in its legend: 0..1, sRGB-encoded.
Eigen::Vector3f reason_color(QualityReason reason);

/// Tint of samples that are not measured, in `SurfaceShading::kStates` and in its legend: 0..1, sRGB-encoded.
Eigen::Vector3f state_color(SampleState state);

struct LightFieldRendererOptions {
  /// Uploaded in one call of `update` at most (8 bytes a texel), so that the window stays fluid; one ring at least.
  std::size_t texels_per_update = std::size_t(4) << 20;
  /// Bound of one GPU buffer in texels; 0 = what the driver allows.
  std::size_t max_buffer_texels = 0;
};

/// Draws a surface light field with OpenGL 3.3: all terms of all three rings of a triangle in one pass of one fragment
/// shader, by the formula of the CPU's `ViewShader`. Surface maps stay on the GPU as half floats; view coefficients are
/// computed on the CPU a frame.
class LightFieldRenderer {
 public:
  /// With a context current. Throws DeviceError where a shader is refused.
  explicit LightFieldRenderer(const LightFieldRendererOptions& options = {});

  /// Brings rings that changed since the last call to the GPU, those that are not there at all first. True when
  /// everything is there; else the rings still to come are drawn as they were, and the next call goes on. Throws
  /// DeviceError when the mesh itself does not fit.
  bool update(const std::shared_ptr<const SurfaceLightFieldSnapshot>& snapshot);

  /// Draws into a panel of a target of `target_height` pixels; depth-tested within it, background untouched.
  void draw(const Viewpoint& viewpoint, const Panel& panel, int target_height, SurfaceShading shading);

  /// Rings of which the GPU has no room for all terms: drawn with the strongest ones.
  std::size_t shortened_rings() const { return shortened_rings_; }
  std::size_t texels_used() const { return store_.texels_used(); }
  std::size_t texels_reserved() const { return store_.texels_reserved(); }

 private:
  void upload_mesh(const SurfaceLightFieldSnapshot& snapshot);
  bool upload_rings(const SurfaceLightFieldSnapshot& snapshot);
  void upload_coefficients(const Eigen::Vector3d& eye);
  void upload_quality(const Eigen::Vector3d& eye);

  LightFieldRendererOptions options_;
  GlProgram program_;
  GlHandle vertex_array_;
  BasisStore store_;
  BufferTexture positions_;     ///< a vertex: x, y, z, 1
  BufferTexture corners_;       ///< a triangle's corner: vertex, first sample in the vertex's ring
  BufferTexture resolutions_;   ///< a triangle
  BufferTexture slots_;         ///< a vertex: first texel, rank | buffer << 16
  BufferTexture coefficients_;  ///< a vertex: `stride_` values
  BufferTexture quality_;       ///< a triangle: heuristic, reason

  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const VertexRings> rings_;
  std::vector<std::shared_ptr<const RingSnapshot>> uploaded_;  ///< a vertex: what the GPU holds
  std::vector<BasisSlot> ring_slots_;
  std::size_t shortened_rings_ = 0;
  std::size_t triangle_count_ = 0;

  /// The rings as the GPU has them: coefficients belong to the basis that is there, not to the newest one.
  std::optional<SurfaceLightFieldSnapshot> shown_;
  ExposureField exposure_;
  int stride_ = 0;
  std::optional<Eigen::Vector3d> coefficients_eye_, quality_eye_;  ///< empty: to be computed anew
};

}  // namespace sheen
