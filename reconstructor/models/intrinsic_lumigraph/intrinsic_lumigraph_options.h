// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/models/model_settings.h"

namespace sheen {

/// Nothing is to be set but what all models do with images, and of that only which are held out.
struct IntrinsicLumigraphOptions : ModelSettings {
  static constexpr const char* kName = "intrinsic_lumigraph";

  const char* kind() const override { return kName; }
  std::unique_ptr<ModelSettings> clone() const override { return std::make_unique<IntrinsicLumigraphOptions>(*this); }
  std::vector<SettingKey> keys() override { return image_keys(); }
  void require_valid() const override { require_valid_images(); }
  int effort_levels() const override { return 1; }
  /// Of a mesh, which says nothing of the pictures: not known.
  MemoryNeed memory_need(std::size_t, std::size_t) const override { return {}; }
  bool makes_mesh() const override { return true; }
  std::optional<Mesh> own_mesh(const PosedCamera& camera) const override;
  bool takes_mesh() const override { return true; }
  std::unique_ptr<AppearanceModel> make_model(std::shared_ptr<const Mesh> mesh,
                                              std::shared_ptr<const RayScene> scene) const override;
  std::unique_ptr<Baselines> make_baselines(std::shared_ptr<const ModelSnapshot> snapshot,
                                            bool photographs) const override;
};

}  // namespace sheen
