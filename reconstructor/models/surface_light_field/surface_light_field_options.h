// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "reconstructor/models/model_settings.h"
#include "reconstructor/models/surface_light_field/capture_guidance.h"
#include "reconstructor/models/surface_light_field/patch_model.h"

namespace sheen {

/// What a scene asks of a surface light field.
struct SurfaceLightFieldOptions : ModelSettings {
  /// Side of a triangle's surface map; 0 = from the footprint of a pixel in the first image.
  int surface_map = 0;
  int min_surface_map = 4, max_surface_map = 24;  ///< bounds of the choice by footprint (MapResolutionOptions)
  double map_scale = 1;                           ///< of the side, given or chosen
  /// What coarser maps may miss of what is displayed, over the error with which the patch predicts each of its views
  /// from the others, or all patches the images, whichever is less: where half or a quarter of the side is enough, maps
  /// get it. 0: all maps keep the sides that the first image gives them.
  double map_detail = 0.02;
  PatchModelOptions patch;
  GuidanceMethod guidance = GuidanceMethod::kExpectedError;

  /// Whether maps of chroma may be coarser than those of luma.
  bool coarse_chroma() const { return map_detail > 0; }

  const char* kind() const override { return kName; }
  std::unique_ptr<ModelSettings> clone() const override { return std::make_unique<SurfaceLightFieldOptions>(*this); }
  std::vector<SettingKey> keys() override;
  void require_valid() const override;
  std::string no_small_form() const override;
  int effort_levels() const override;
  MemoryNeed memory_need(std::size_t vertices, std::size_t triangles) const override;
  std::unique_ptr<AppearanceModel> make_model(std::shared_ptr<const Mesh> mesh,
                                              std::shared_ptr<const RayScene> scene) const override;
  std::unique_ptr<Baselines> make_baselines(std::shared_ptr<const ModelSnapshot> snapshot,
                                            bool photographs) const override;

  static constexpr const char* kName = "surface_light_field";
};

/// Of settings that may be another model's: then throws ConfigError that says `who` wants a surface light field.
const SurfaceLightFieldOptions& light_field_options(const ModelSettings& settings, const std::string& who);

}  // namespace sheen
