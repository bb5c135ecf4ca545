// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "reconstructor/lumigraph_file/lumigraph_data.h"
#include "reconstructor/models/intrinsic_lumigraph/mean_look.h"
#include "reconstructor/models/intrinsic_lumigraph/seen_surface.h"
#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/models/surface_properties.h"

namespace sheen {

/// The intrinsic lumigraph of a scene (001), at one moment: its picture from any eye in any light. Light is asked for
/// as `ViewQuery::light`; a fixed light is the captured one nearest to the middle of all.
class IntrinsicLumigraphSnapshot : public ModelSnapshot, public KnownSurface {
 public:
  /// `occluders`: of the mesh; null where the data are of images, and the mesh their `view_plane`.
  IntrinsicLumigraphSnapshot(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const Occluders> occluders,
                             std::shared_ptr<const LumigraphData> data, std::uint64_t version);

  const std::shared_ptr<const LumigraphData>& data() const { return data_; }
  const std::shared_ptr<const Occluders>& shared_occluders() const { return occluders_; }
  const MeanLook& mean_look() const { return *mean_look_; }  ///< likewise of the mesh, where there are views
  /// Of a query. Throws ConfigError for a light of another kind than those of the images.
  Eigen::Vector3d light_place(const LightState& light) const;

  /// Colours of a view in a light, its brightness included; where there is no mesh shadow has fallen on them, and
  /// `dark` is empty.
  RelitView relit(const IntrinsicView& view, const LightState& light) const;

  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override;
  bool is_mesh() const override { return !data_->of_images; }
  std::shared_ptr<const Appearance> property(SurfaceProperty property) const override;
  std::optional<AverageLook> average_look() const override;
  const std::shared_ptr<const Mesh>& shared_mesh() const override { return mesh_; }
  std::uint64_t version() const override { return version_; }
  bool empty() const override { return data_->views.empty(); }
  const std::vector<PosedCamera>& cameras() const override { return cameras_; }
  SnapshotFigures figures() const override;
  std::size_t memory_bytes() const override;
  LightKind light_kind() const override { return data_->lights.kind; }
  std::vector<LightState> lights() const override;
  std::shared_ptr<const ModelSnapshot> filled() const override;
  ViewAdvice advise_next_view(const Eigen::Vector3d& eye) const override;
  std::unique_ptr<Compression> compression(CompressionTarget target) const override;
  void save(const std::filesystem::path& folder, const ModelMetadata& metadata,
            const StepsDone& progress) const override;

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const Occluders> occluders_;
  std::shared_ptr<const LumigraphData> data_;
  std::uint64_t version_;
  std::vector<PosedCamera> cameras_;
  std::shared_ptr<const MeanLook> mean_look_;
};

/// The same captures without knowledge of light: for each view the linear interpolation of its images, or, where
/// `every_light` is set, their mean whatever the light. Views are blended as those of the lumigraph.
class InterpolatedImages : public Appearance {
 public:
  InterpolatedImages(std::shared_ptr<const IntrinsicLumigraphSnapshot> model, bool every_light)
      : model_(std::move(model)), every_light_(every_light) {}
  const Mesh& mesh() const override { return model_->mesh(); }
  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override;

 private:
  std::shared_ptr<const IntrinsicLumigraphSnapshot> model_;
  bool every_light_;
};

}  // namespace sheen
