// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "reconstructor/light_field_file/compact_model.h"
#include "reconstructor/models/surface_light_field/light_field_snapshot.h"
#include "reconstructor/numerics/packed_columns.h"

namespace sheen {

/// A surface light field as it is stored: a patch for a few triangles (CompactModel), and for each vertex the kriging
/// of the coefficients of its patches. What no image showed has a guess already.
class CompactLightField : public LightFieldSnapshot, public std::enable_shared_from_this<CompactLightField> {
 public:
  /// `encoded`: the file that the model stands for, which `save` writes; null for one that is only looked at.
  CompactLightField(CompactModel model, std::shared_ptr<const std::string> encoded);

  SnapshotFigures figures() const override { return figures_; }
  std::size_t memory_bytes() const override;
  std::shared_ptr<const ModelSnapshot> filled() const override;
  std::unique_ptr<Compression> compression(CompressionTarget target) const override;
  void save(const std::filesystem::path& path, const ModelMetadata& metadata, const StepsDone& progress) const override;

  std::size_t patch_count() const override { return patches_.size(); }
  std::shared_ptr<const SurfacePatch> patch(std::size_t index) const override { return patches_[index]; }
  std::size_t patch_bytes(std::size_t index) const override {
    return patches_[index]->basis.bytes() + patches_[index]->shown.size();
  }
  bool seen(std::size_t triangle) const override;
  TrianglePlace place(std::size_t triangle) const override;
  Eigen::MatrixXf coefficients_for(const Eigen::Vector3d& eye) const override;
  std::shared_ptr<const LightFieldSnapshot> with_patches(
      const std::vector<std::shared_ptr<const SurfacePatch>>& patches) const override;
  const SeenVertex* seen_vertex(std::size_t vertex) const override;
  double vertex_variation(std::size_t vertex) const override { return seen_[vertex].sill; }
  int max_rank() const override { return patches_.empty() ? 0 : 1 + max_terms_; }
  float common_sill() const override { return common_sill_; }

 private:
  /// Kriging of the terms of all patches round a vertex, one below the other: h = mean + drift * reflection + weights
  /// * k.
  struct Interpolant {
    std::shared_ptr<const VertexViews> views;
    PackedColumns<float> weights;
    Eigen::VectorXf mean, drift;
    std::vector<std::uint32_t> patches, columns;  ///< round the vertex, and where their coefficients go
  };
  void interpolate_at(const CompactModel& model, std::size_t vertex, const Eigen::Vector3f& normal);

  std::vector<std::shared_ptr<const SurfacePatch>> patches_;  ///< the mean map, then the terms
  PatchShapes shapes_;
  std::vector<Interpolant> interpolants_;  ///< per vertex
  std::vector<SeenVertex> seen_;           ///< per vertex; without views where no image showed it
  float common_sill_ = 0;
  int max_terms_ = 0;
  SnapshotFigures figures_;
  std::shared_ptr<const std::string> encoded_;
};

}  // namespace sheen
