// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "reconstructor/light_field_file/compact_model.h"
#include "reconstructor/light_field_file/light_field_evaluator.h"
#include "reconstructor/models/surface_light_field/light_field_snapshot.h"

namespace sheen {

/// A surface light field as it is stored: a patch for a few triangles (CompactModel), and for each vertex the kriging
/// of the coefficients of its patches (LightFieldEvaluator). What no image showed has a guess already.
class CompactLightField : public LightFieldSnapshot, public std::enable_shared_from_this<CompactLightField> {
 public:
  /// `encoded`: the file that the model stands for, which `save` writes; null for one that is only looked at.
  CompactLightField(CompactModel model, std::shared_ptr<const std::string> encoded);

  SnapshotFigures figures() const override { return figures_; }
  std::size_t memory_bytes() const override;
  std::shared_ptr<const ModelSnapshot> filled() const override;
  std::unique_ptr<Compression> compression(CompressionTarget target) const override;
  void save(const std::filesystem::path& path, const ModelMetadata& metadata, const StepsDone& progress) const override;

  std::size_t patch_count() const override { return light_field_.patches().size(); }
  std::shared_ptr<const SurfacePatch> patch(std::size_t index) const override { return light_field_.patches()[index]; }
  std::size_t patch_bytes(std::size_t index) const override {
    const SurfacePatch& patch = *light_field_.patches()[index];
    return patch.basis.bytes() + patch.shown.size();
  }
  bool seen(std::size_t triangle) const override;
  TrianglePlace place(std::size_t triangle) const override;
  Eigen::MatrixXf coefficients_for(const Eigen::Vector3d& eye) const override;
  Eigen::MatrixXf average_coefficients() const override;
  std::shared_ptr<const LightFieldSnapshot> with_patches(
      const std::vector<std::shared_ptr<const SurfacePatch>>& patches) const override;
  const SeenVertex* seen_vertex(std::size_t vertex) const override;
  double vertex_variation(std::size_t vertex) const override { return seen_[vertex].sill; }
  int max_rank() const override { return light_field_.max_rank(); }
  float common_sill() const override { return common_sill_; }

 private:
  LightFieldEvaluator light_field_;
  std::vector<SeenVertex> seen_;  ///< per vertex; without views where no image showed it
  float common_sill_ = 0;
  SnapshotFigures figures_;
  std::shared_ptr<const std::string> encoded_;
};

}  // namespace sheen
