// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "reconstructor/light_field_file/patch_shapes.h"
#include "reconstructor/models/surface_light_field/light_field_snapshot.h"
#include "reconstructor/models/surface_light_field/patch_snapshot.h"

namespace sheen {

/// A mesh of which nothing is known yet but, perhaps, from where its images were taken.
std::shared_ptr<const ModelSnapshot> bare_mesh(std::shared_ptr<const Mesh> mesh, std::vector<PosedCamera> cameras);

/// A surface light field as it is captured. Unchanged patches are shared between snapshots; a patch that no image has
/// reached is null.
class SurfaceLightFieldSnapshot : public LightFieldSnapshot {
 public:
  using Patches = std::vector<std::shared_ptr<const PatchSnapshot>>;  ///< as the shapes have them

  SurfaceLightFieldSnapshot(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const MapLayout> maps,
                            std::shared_ptr<const PatchShapes> shapes, Patches patches, std::uint64_t version,
                            ExposureField exposure = {}, std::vector<PosedCamera> cameras = {},
                            GuidanceMethod guidance = GuidanceMethod::kExpectedError);

  SnapshotFigures figures() const override;
  std::size_t memory_bytes() const override;
  std::shared_ptr<const ModelSnapshot> filled() const override;
  std::unique_ptr<Compression> compression(CompressionTarget target) const override;
  void save(const std::filesystem::path& folder, const ModelMetadata& metadata,
            const StepsDone& progress) const override;

  const std::shared_ptr<const PatchShapes>& shared_shapes() const { return shapes_; }
  const PatchShapes& shapes() const { return *shapes_; }
  const Patches& patches() const { return patches_; }
  /// Of the patches round a vertex that an image showed, the one with most views; null where there is none.
  const VertexInterpolant* seen_at(std::size_t vertex) const;
  /// Views are interpolated as the paper does it (`VertexInterpolant::triangulation`).
  bool triangulated() const;

  std::size_t patch_count() const override { return patches_.size(); }
  std::shared_ptr<const SurfacePatch> patch(std::size_t index) const override { return patches_[index]; }
  std::size_t patch_bytes(std::size_t index) const override { return patches_[index]->bytes(); }
  bool seen(std::size_t triangle) const override;
  TrianglePlace place(std::size_t triangle) const override;
  Eigen::MatrixXf coefficients_for(const Eigen::Vector3d& eye) const override;
  /// Of the patches that are wanted; zero of all others.
  Eigen::MatrixXf coefficients_for(const Eigen::Vector3d& eye, const std::vector<bool>& wanted) const;
  Eigen::MatrixXf average_coefficients() const override;
  std::shared_ptr<const LightFieldSnapshot> with_patches(
      const std::vector<std::shared_ptr<const SurfacePatch>>& patches) const override;
  const SeenVertex* seen_vertex(std::size_t vertex) const override { return seen_at(vertex); }
  double vertex_variation(std::size_t vertex) const override;
  int max_rank() const override;
  float common_sill() const override { return common_sill_; }

 private:
  std::shared_ptr<const PatchShapes> shapes_;
  Patches patches_;
  float common_sill_;
};

}  // namespace sheen
