// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"

#include <string>
#include <utility>

#include "common/base/errors.h"
#include "reconstructor/models/surface_light_field/effort_levels.h"
#include "reconstructor/models/surface_light_field/light_field_baselines.h"
#include "reconstructor/models/surface_light_field/memory_account.h"
#include "reconstructor/models/surface_light_field/surface_light_field.h"

namespace sheen {

std::vector<SettingKey> SurfaceLightFieldOptions::keys() {
  std::vector<SettingKey> keys = image_keys();
  const std::vector<SettingKey> own = {
      setting("surface_map", surface_map),
      setting("max_rank", patch.factor.max_rank),
      setting("tolerance", patch.factor.tolerance),
      setting("map_scale", map_scale, SettingTable::kAdvanced),
      setting("map_detail", map_detail, SettingTable::kAdvanced),
      setting("internal_rank", patch.factor.internal_rank, SettingTable::kAdvanced),
      setting("block", patch.factor.block, SettingTable::kAdvanced),
      setting("max_views", patch.max_views, SettingTable::kAdvanced),
      setting("repeat_angle", patch.repeat_angle, SettingTable::kAdvanced),
      setting("min_visible", patch.min_visible, SettingTable::kAdvanced),
      setting("interpolation", patch.interpolation.method,
              {{ViewMethod::kKriging, "kriging"}, {ViewMethod::kDelaunay, "delaunay"}}, SettingTable::kStudy),
      setting("imputation", patch.factor.imputation,
              {{Imputation::kMostProbable, "most-probable"}, {Imputation::kLeastSquares, "least-squares"}},
              SettingTable::kStudy),
      setting("visibility", visibility.test,
              {{VisibilityTest::kSamples, "samples"}, {VisibilityTest::kVertices, "vertices"}}, SettingTable::kStudy),
      setting(
          "guidance", guidance,
          {{GuidanceMethod::kExpectedError, "expected-error"}, {GuidanceMethod::kPaperHeuristic, "paper-heuristic"}},
          SettingTable::kStudy),
  };
  keys.insert(keys.end(), own.begin(), own.end());
  return keys;
}

void SurfaceLightFieldOptions::require_valid() const {
  require_valid_images();
  const auto require = [](bool holds, const char* rule) {
    if (!holds) throw ConfigError(std::string(kName) + ": " + rule);
  };
  require(surface_map == 0 || (surface_map >= 2 && surface_map <= 64),
          "surface_map must be 0 (chosen from the footprint) or 2..64");
  require(map_scale >= 0.05 && map_scale <= 4, "map_scale must be in [0.05, 4]");
  require(map_detail >= 0 && map_detail <= 1, "map_detail must be in [0, 1]");
  require(patch.repeat_angle >= 0 && patch.repeat_angle < 0.5, "repeat_angle must be in [0, 0.5) rad");
  require(patch.factor.max_rank >= 1 && patch.factor.max_rank <= 64, "max_rank must be 1..64");
  require(patch.factor.internal_rank == 0 ||
              (patch.factor.internal_rank >= patch.factor.max_rank && patch.factor.internal_rank <= 64),
          "internal_rank must be 0 (chosen from max_rank) or max_rank..64");
  require(patch.factor.block >= 1 && patch.factor.block <= 32, "block must be 1..32");
  require(patch.factor.tolerance >= 0 && patch.factor.tolerance < 1, "tolerance must be in [0, 1)");
  require(patch.min_visible >= 0 && patch.min_visible <= 1, "min_visible must be in [0, 1]");
  require(patch.max_views >= 8 && patch.max_views <= 1000, "max_views must be 8..1000");
}

std::string SurfaceLightFieldOptions::no_small_form() const {
  if (patch.interpolation.method == ViewMethod::kKriging) return {};
  return "small files hold views that kriging interpolates between, and interpolation is \"delaunay\"";
}

int SurfaceLightFieldOptions::effort_levels() const {
  return static_cast<int>(all_effort_levels().size());
}

MemoryNeed SurfaceLightFieldOptions::memory_need(std::size_t /*vertices*/, std::size_t triangles) const {
  return sheen::memory_need(triangles, *this);
}

std::unique_ptr<AppearanceModel> SurfaceLightFieldOptions::make_model(std::shared_ptr<const Mesh> mesh,
                                                                      std::shared_ptr<const RayScene> scene) const {
  return std::make_unique<SurfaceLightField>(std::move(mesh), *this, std::move(scene));
}

std::unique_ptr<Baselines> SurfaceLightFieldOptions::make_baselines(std::shared_ptr<const ModelSnapshot> snapshot,
                                                                    bool photographs) const {
  return std::make_unique<LightFieldBaselines>(std::dynamic_pointer_cast<const LightFieldSnapshot>(snapshot), *this,
                                               photographs);
}

const SurfaceLightFieldOptions& light_field_options(const ModelSettings& settings, const std::string& who) {
  if (const auto* options = dynamic_cast<const SurfaceLightFieldOptions*>(&settings)) return *options;
  throw ConfigError(who + " works on surface light fields; the scene asks for " + settings.kind());
}

}  // namespace sheen
