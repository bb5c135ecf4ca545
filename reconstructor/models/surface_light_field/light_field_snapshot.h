// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "reconstructor/light_field_file/patch_shapes.h"
#include "reconstructor/light_field_file/surface_patch.h"
#include "reconstructor/light_field_file/vertex_views.h"
#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/models/surface_demand.h"
#include "reconstructor/models/surface_light_field/capture_guidance.h"
#include "reconstructor/radiance/exposure_field.h"
#include "reconstructor/surface/map_layout.h"

namespace sheen {

/// How what the triangles round a vertex show varies with the view.
struct SeenVertex {
  std::shared_ptr<const VertexViews> views;  ///< never null
  float sill = 0;                            ///< mean square per value: how much it varies (`ViewInterpolant::sill`)
  float residual = 0;                        ///< psi_p: smoothed relative projection error of new images, 0..1
  int views_folded = 0;                      ///< images ingested, thinned ones included
};

/// What is known of a model by the file that it comes from.
struct FileFacts {
  float missing_square = 0;                                  ///< of what it lacks: of encoded values in pictures
  float brightest = std::numeric_limits<float>::infinity();  ///< encoded colour that is drawn
};

/// An immutable surface light field (000): a triangle's surface maps times the mean of its corners' view coefficients,
/// weighted barycentrically. Patches of triangles share maps.
class LightFieldSnapshot : public ModelSnapshot, public DemandingSurface {
 public:
  LightFieldSnapshot(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const MapLayout> maps, std::uint64_t version,
                     ExposureField exposure, std::vector<PosedCamera> cameras, GuidanceMethod guidance,
                     FileFacts file = {})
      : mesh_(std::move(mesh)),
        maps_(std::move(maps)),
        version_(version),
        exposure_(std::move(exposure)),
        cameras_(std::move(cameras)),
        guidance_method_(guidance),
        file_(file) {}

  const std::shared_ptr<const Mesh>& shared_mesh() const override { return mesh_; }
  std::uint64_t version() const override { return version_; }
  bool empty() const override { return max_rank() == 0; }
  const std::vector<PosedCamera>& cameras() const override { return cameras_; }
  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override;
  std::optional<AverageLook> average_look() const override;
  ViewAdvice advise_next_view(const Eigen::Vector3d& eye) const override;

  std::vector<SurfaceDemand> demand() const override;

  const std::shared_ptr<const MapLayout>& shared_maps() const { return maps_; }
  const MapLayout& maps() const { return *maps_; }
  const ExposureField& exposure() const { return exposure_; }
  float brightest() const { return file_.brightest; }
  float missing_square() const { return file_.missing_square; }
  GuidanceMethod guidance_method() const { return guidance_method_; }

  virtual std::size_t patch_count() const = 0;
  virtual std::shared_ptr<const SurfacePatch> patch(std::size_t index) const = 0;  ///< null: no image has reached it
  virtual std::size_t patch_bytes(std::size_t index) const = 0;                    ///< of one that is there
  virtual bool seen(std::size_t triangle) const = 0;  ///< some image showed something of its patch
  virtual TrianglePlace place(std::size_t triangle) const = 0;
  /// View coefficients for this eye: max_rank() x columns (`TrianglePlace::columns`), zero-padded. What a GPU needs per
  /// frame.
  virtual Eigen::MatrixXf coefficients_for(const Eigen::Vector3d& eye) const = 0;
  /// The same of all views that there are together: of each column the mean over those from its vertex.
  virtual Eigen::MatrixXf average_coefficients() const = 0;
  /// The same snapshot with these patches in place of its own, which are newer: what a GPU holds that is still
  /// being filled.
  virtual std::shared_ptr<const LightFieldSnapshot> with_patches(
      const std::vector<std::shared_ptr<const SurfacePatch>>& patches) const = 0;

  /// Null where no image showed anything of the vertex's triangles.
  virtual const SeenVertex* seen_vertex(std::size_t vertex) const = 0;
  /// How much the vertex varies with the view: mean over its views of the mean square over its rows, encoded.
  virtual double vertex_variation(std::size_t vertex) const = 0;
  virtual float common_sill() const = 0;  ///< mean of the vertices' sills

  virtual int max_rank() const = 0;                                           ///< of all patches
  std::vector<SurfaceQuality> quality_for(const Eigen::Vector3d& eye) const;  ///< per triangle, by the guidance

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const MapLayout> maps_;
  std::uint64_t version_;
  ExposureField exposure_;
  std::vector<PosedCamera> cameras_;
  GuidanceMethod guidance_method_;
  FileFacts file_;
  mutable std::once_flag guidance_made_;
  mutable std::unique_ptr<const CaptureGuidance> guidance_;
};

}  // namespace sheen
