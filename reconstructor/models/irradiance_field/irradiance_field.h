// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "reconstructor/models/appearance_model.h"
#include "reconstructor/models/irradiance_field/irradiance_field_options.h"
#include "reconstructor/models/irradiance_field/irradiance_field_snapshot.h"
#include "reconstructor/models/irradiance_field/undistortion.h"

namespace sheen {

/// The reflected irradiance field as it is built (002): one camera's images in lights that move. It keeps them all;
/// what is learned from them, terms and kernel, is found when it is asked for. All images are of one camera that stands
/// still, each in a light of one kind (directional, or point), none from the same place as another.
class IrradianceField : public AppearanceModel {
 public:
  /// mesh: `picture_plane` of the camera without its distortion. Throws ConfigError for another.
  IrradianceField(std::shared_ptr<const Mesh> mesh, const IrradianceFieldOptions& options);

  /// Refuses as "no_pose", "no_light_position", "other_kind_of_light", "broken_light", "same_light", "other_camera",
  /// "broken_pixels" (some are masked, or not finite).
  IngestReport ingest(const Capture& capture) override;
  bool withdraw(const Capture& capture) override;
  bool began_with(const Capture& capture) const override;
  void restart(int effort_level) override;
  std::shared_ptr<const ModelSnapshot> snapshot() override;
  std::shared_ptr<const Appearance> constant_colour() const override;
  const ModelSettings& settings() const override { return options_; }
  ModelFigures figures() const override;
  MemoryAccount memory(const CaptureSize& image) const override;

 private:
  struct LitImage {
    std::string source_session;
    std::uint64_t sequence = 0;
    LightState light;
    ImageF encoded;  ///< in light of brightness 1, grey levels of 255
  };
  std::string refusal(const Capture& capture) const;

  std::shared_ptr<const Mesh> mesh_;
  IrradianceFieldOptions options_;
  std::vector<LitImage> images_;
  PosedCamera camera_;  ///< of the first image
  Undistortion undistortion_;
  std::uint64_t version_ = 0;
  std::shared_ptr<const IrradianceFieldSnapshot> newest_;  ///< null where an image came or went since
};

}  // namespace sheen
