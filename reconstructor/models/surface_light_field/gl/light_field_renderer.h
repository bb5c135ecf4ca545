// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "reconstructor/models/surface_light_field/gl/basis_store.h"
#include "reconstructor/models/surface_light_field/gl/light_field_shaders.h"
#include "reconstructor/models/surface_light_field/light_field_snapshot.h"
#include "reconstructor/render/gl/gl_objects.h"
#include "reconstructor/render/gl/model_drawer.h"

namespace sheen {

/// Draws a surface light field with OpenGL 3.3: all terms at all three corners of a triangle in one pass of one
/// fragment shader, by the formula of the CPU's `ViewShader`. Surface maps stay on the GPU as half floats; view
/// coefficients are computed on the CPU for each frame.
class LightFieldRenderer : public ModelDrawer {
 public:
  /// With a context current. Throws DeviceError where a shader is refused.
  explicit LightFieldRenderer(const DrawerOptions& options = {});

  /// Patches that are not there at all first.
  bool update(const std::shared_ptr<const ModelSnapshot>& model) override;
  void draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) override;
  std::vector<std::string> notes() const override;

  /// Patches of which the GPU has no room for all terms: drawn with the strongest ones.
  std::size_t shortened_patches() const { return shortened_patches_; }
  std::size_t texels_used() const { return store_.texels_used(); }
  std::size_t texels_reserved() const { return store_.texels_reserved(); }

 private:
  /// Makes the program for what is on the GPU, where it is not that already.
  void make_program();
  void upload_mesh(const LightFieldSnapshot& snapshot);
  void upload_maps(const LightFieldSnapshot& snapshot);
  /// The same patches, of which some have other maps now. False when they are not the same.
  bool follow_maps(const LightFieldSnapshot& snapshot);
  bool upload_patches(const LightFieldSnapshot& snapshot);
  void upload_coefficients(const Eigen::Vector3d& eye);
  void upload_quality(const Eigen::Vector3d& eye);
  void upload_demand(Demand demand);  ///< in the place of the quality
  void upload_evidence();             ///< likewise
  /// The order in which triangles are drawn: what can hide others first, so that little is shaded in vain.
  void upload_order(const Eigen::Vector3d& eye);

  DrawerOptions options_;
  SurfaceShaderVariant variant_;
  GlProgram program_;  ///< of `variant_`
  GlHandle vertex_array_;
  BasisStore store_;
  GlHandle order_;              ///< element buffer: corners of the triangles as they are drawn
  BufferTexture positions_;     ///< per vertex: x, y, z, 1
  BufferTexture corners_;       ///< a triangle's corner: vertex, and of its TrianglePlace patch, sample, column
  BufferTexture resolutions_;   ///< per triangle
  BufferTexture slots_;         ///< per patch: first texel, rank | buffer << 16
  BufferTexture coefficients_;  ///< per column: `stride_` values
  BufferTexture quality_;       ///< per triangle: heuristic, reason; or a level of demand, or of evidence

  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const MapLayout> maps_;
  std::vector<std::shared_ptr<const SurfacePatch>> uploaded_;  ///< per patch: what the GPU holds
  std::vector<BasisSlot> patch_slots_;
  std::vector<std::uint32_t> patch_of_;   ///< per triangle
  std::vector<std::uint8_t> other_maps_;  ///< per patch: what the GPU holds of it does not fit its maps
  std::size_t shortened_patches_ = 0;
  std::size_t triangle_count_ = 0;

  /// The patches as the GPU has them: coefficients belong to the basis that is there, not to the newest one.
  std::shared_ptr<const LightFieldSnapshot> shown_;
  ExposureField exposure_;
  int stride_ = 0;
  std::optional<Demand> demand_;  ///< that `quality_` has; empty: it has quality, or must be made again
  std::optional<Eigen::Vector3d> coefficients_eye_, quality_eye_, order_eye_;  ///< empty: to be computed again
};

}  // namespace sheen
