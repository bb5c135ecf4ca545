// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "reconstructor/irradiance_field_file/field_lights.h"
#include "reconstructor/irradiance_field_file/quantised_field.h"
#include "reconstructor/irradiance_field_file/relighting.h"
#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/models/surface_properties.h"

namespace sheen {

/// The reflected irradiance field of a scene (002), at one moment: a fixed camera's picture in any light. Its surface
/// is the picture plane. Light is asked for as `ViewQuery::light`; a fixed light is that of all images together.
class IrradianceFieldSnapshot : public ModelSnapshot, public KnownSurface {
 public:
  /// mesh: the camera's picture plane. `field`: of the scene's lights; without any, the picture is black.
  /// `in_one_file`: what `save` writes; else a folder.
  IrradianceFieldSnapshot(std::shared_ptr<const Mesh> mesh, LitScene scene, QuantisedField field, std::uint64_t version,
                          bool in_one_file);

  /// Linear radiance, 3 channels, of the camera's picture. Throws ConfigError as `FieldLights::known`.
  ImageF picture(const LightState& light) const;
  /// The same for a screen: 8-bit sRGB, what `to_srgb8` makes of it but for rounding. In white light levels are not
  /// decoded first: half the time.
  ImageU8 screen_picture(const LightState& light) const;
  const LitScene& scene() const { return scene_; }
  const QuantisedField& field() const { return *field_; }

  bool is_mesh() const override { return false; }
  std::shared_ptr<const Appearance> property(SurfaceProperty) const override { return nullptr; }
  /// `picture`, read between the pixels linearly. Throws ConfigError likewise.
  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override;
  const std::shared_ptr<const Mesh>& shared_mesh() const override { return mesh_; }
  std::uint64_t version() const override { return version_; }
  bool empty() const override { return field_->lights == 0; }
  const std::vector<PosedCamera>& cameras() const override { return cameras_; }
  SnapshotFigures figures() const override;
  std::size_t memory_bytes() const override { return relighting_ ? relighting_->bytes() : 0; }
  LightKind light_kind() const override { return scene_.kind; }
  std::vector<LightState> lights() const override;
  std::shared_ptr<const ModelSnapshot> filled() const override;
  ViewAdvice advise_next_view(const Eigen::Vector3d& eye) const override;
  std::optional<LightAdvice> advise_next_light(double tolerance) const override;
  std::unique_ptr<Compression> compression(CompressionTarget target) const override;
  void save(const std::filesystem::path& path, const ModelMetadata& metadata, const StepsDone& progress) const override;

 private:
  std::shared_ptr<const Mesh> mesh_;
  LitScene scene_;
  std::shared_ptr<const QuantisedField> field_;  // this and `relighting_` are shared with copies
  std::uint64_t version_;
  bool in_one_file_;
  std::optional<FieldLights> lights_;  ///< none without images
  std::shared_ptr<const Relighting> relighting_;
  std::vector<PosedCamera> cameras_;
};

/// A picture that is the same in every light, on its picture plane.
class FlatPicture : public Appearance {
 public:
  FlatPicture(std::shared_ptr<const Mesh> mesh, ImageF picture, float error)
      : mesh_(std::move(mesh)), picture_(std::make_shared<const ImageF>(std::move(picture))), error_(error) {}
  const Mesh& mesh() const override { return *mesh_; }
  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override;

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const ImageF> picture_;
  float error_;
};

}  // namespace sheen
