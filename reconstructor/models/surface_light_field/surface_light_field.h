// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "reconstructor/models/appearance_model.h"
#include "reconstructor/models/factored_model.h"
#include "reconstructor/models/surface_light_field/constant_colour.h"
#include "reconstructor/models/surface_light_field/snapshot.h"
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"

namespace sheen {

struct LightFieldPipeline;

/// The online surface light field (000): one online SVD per patch of triangles, fed image by image.
class SurfaceLightField : public AppearanceModel, public FactoredModel {
 public:
  /// Throws ConfigError when an option is out of range, naming it.
  /// `scene`: of the mesh, where there is one already; it is made once.
  SurfaceLightField(std::shared_ptr<const Mesh> mesh, const SurfaceLightFieldOptions& options,
                    std::shared_ptr<const RayScene> scene = nullptr);
  ~SurfaceLightField() override;

  IngestReport ingest(const Capture& capture) override;
  /// What the image left in others stays: samples that were imputed with its help, exposures estimated with it. Not for
  /// the first image that showed something, which the size of the maps and the level of exposure come from.
  bool withdraw(const Capture& capture) override;
  bool began_with(const Capture& capture) const override;

  void restart(int effort_level) override;
  void rebuild(int effort_level) override;
  int effort_level_within(const Capture& first, int from, const MemoryLimit& limit) const override;
  bool reduce_memory() override;
  void set_update_fraction(double fraction) override;
  /// All maps become as coarse as this `SurfaceLightFieldOptions::map_detail` lets them, and so from now on.
  void limit_detail(double map_detail);
  /// Lets go of terms and views beyond lower limits, in all patches at once. They hold from now on.
  void limit_patches(const PatchLimit& limit);

  std::shared_ptr<const ModelSnapshot> snapshot() override { return light_field_snapshot(); }
  /// Throws std::logic_error when it was given away.
  std::shared_ptr<const SurfaceLightFieldSnapshot> light_field_snapshot();
  /// `ingest` throws std::logic_error from now on.
  void finish() override;
  std::shared_ptr<const ModelSnapshot> give_snapshot() override;
  std::shared_ptr<const Appearance> constant_colour() const override;

  const SurfaceLightFieldOptions& settings() const override;
  ModelFigures figures() const override;
  NumericalHealth health() const override;
  MemoryAccount memory(const CaptureSize& image) const override;
  std::size_t bytes() const;           ///< of all patches
  std::size_t snapshot_bytes() const;  ///< of a snapshot of all patches
  const MapLayout* maps() const;       ///< null until an image comes

 private:
  void begin(const SurfaceLightFieldOptions& options);

  SurfaceLightFieldOptions asked_;  ///< before any effort level's limits
  std::size_t memory_step_ = 0;     ///< how many of `memory_details`, then of `memory_steps` have been taken
  std::unique_ptr<LightFieldPipeline> pipeline_;
};

}  // namespace sheen
