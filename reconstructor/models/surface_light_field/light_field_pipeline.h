// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/capture/capture.h"
#include "common/capture/trade.h"
#include "common/geometry/mesh.h"
#include "common/geometry/ray_scene.h"
#include "reconstructor/models/appearance_model.h"
#include "reconstructor/models/surface_light_field/constant_colour.h"
#include "reconstructor/models/surface_light_field/folded_images.h"
#include "reconstructor/models/surface_light_field/patch_set.h"
#include "reconstructor/models/surface_light_field/snapshot.h"
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"
#include "reconstructor/radiance/radiance_image.h"
#include "reconstructor/radiance/resampling.h"
#include "reconstructor/surface/sample_visibility.h"

namespace sheen {

/// How an image goes through: what it shows is found, brought to one exposure, and folded into the patches that it
/// tells something new.
struct LightFieldPipeline {
  LightFieldPipeline(std::shared_ptr<const Mesh> of_mesh, const SurfaceLightFieldOptions& chosen,
                     std::shared_ptr<const RayScene> of_scene)
      : mesh(std::move(of_mesh)), scene(std::move(of_scene)), options(chosen) {}

  std::shared_ptr<const Mesh> mesh;
  std::shared_ptr<const RayScene> scene;
  SurfaceLightFieldOptions options;
  std::vector<Eigen::Matrix3f> frames;  ///< of the vertices' hemispheres

  /// The first image that shows something decides about maps and exposure.
  struct Beginning {
    ImageName image;
    Camera camera;
    Rigid3 camera_from_object;
    double exposure;  ///< its product, 0 when unknown
  };
  std::optional<Beginning> beginning;
  // From the first image on:
  std::shared_ptr<const MapLayout> shape;
  std::unique_ptr<SampleVisibility> visibility;
  std::shared_ptr<ConstantColour> constant_colour;
  std::optional<PatchSet> patches;
  double update_fraction = 1;  ///< of the patches that an image shows: those that it updates

  RadianceImage image;
  FoldedImages folded;
  double squared_error = 0;  ///< with which images are predicted, encoded: a running mean; 0: none was
  std::uint64_t version = 0;

  /// What the patches leave behind.
  struct Finished {
    ModelFigures figures;
    NumericalHealth health;
    std::size_t snapshot_bytes;
    std::shared_ptr<const SurfaceLightFieldSnapshot> snapshot;
  };
  std::optional<Finished> finished;

  void start(const Beginning& first);
  IngestReport ingest(const Capture& capture);
  bool withdraw(const Capture& capture);
  /// Patches of which nothing fine is displayed get coarser maps.
  void coarsen_maps(const std::vector<std::uint32_t>& asked);
  ExposureField exposure_field() const { return folded.exposure_field(bounding_sphere(*mesh).centre.cast<float>()); }

 private:
  MapSides map_sides(const Camera& camera, const Rigid3& camera_from_object) const;
  bool use(std::shared_ptr<const MapLayout> maps);
  bool refine_maps(const SurfaceView& view, const Beginning& here);
  void follow_error(double predicted_psnr_db);
  const SurfaceView& look(const Capture& capture);
  SurfaceImage divided_by(float gain, const SurfaceView& view) const {
    return {image, view, *shape, gain, options.sampling};
  }
  float known_gain(const Capture& capture) const;
  float estimated_gain(const Capture& capture, const SurfaceView& view) const;
  bool repeats_earlier_image(const SurfaceView& view, IngestReport& report);
  std::vector<std::uint32_t> patches_to_update(const SurfaceView& view, IngestReport& report) const;
  std::vector<bool> factorize(const SurfaceView& view, IngestReport& report);
  double predicted_psnr_db(const SurfaceImage& shown, const std::vector<std::uint32_t>& chosen) const;
};

}  // namespace sheen
