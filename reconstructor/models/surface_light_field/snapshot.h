// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "reconstructor/models/surface_light_field/light_field_snapshot.h"
#include "reconstructor/numerics/view_kriging.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {

/// The light field of one vertex ring, factorized (000 sec. 4.1): surface maps of all its triangles, and view functions
/// h_r interpolated by kriging:
/// h(d) = mean + drift * reflection(d mirrored about the normal) + sum_j weights.col(j) * k(angle(d,
/// directions.col(j))).
struct RingSnapshot : SurfacePatch, RingViews {
  Eigen::MatrixXf weights;  ///< rank x views: kriging in its dual form
  Eigen::VectorXf mean;     ///< rank
  Eigen::VectorXf drift;    ///< rank: of the reflection that all rings share; empty where the ring does without
  /// Where views are interpolated as the paper does it, for comparison: `weights` are the views' own coefficients then,
  /// and mean and drift are none. Null for kriging.
  std::shared_ptr<const ViewTriangulation> triangulation;

  /// Takes over mean, weights, drift and sill. The basis and `shown` must be there already. `shared`: the reflection
  /// that the interpolant's drift is of, if it has one.
  void set_interpolation(ViewInterpolant interpolant, const ViewKernel& view_kernel,
                         std::shared_ptr<const ReflectionDrift> shared);

  /// Interpolates the views' coefficients (rank x views) over the Delaunay triangulation of their directions instead.
  void set_triangulation(const Eigen::MatrixXf& coefficients);

  bool seen() const;  ///< some image showed something of it
  std::size_t bytes() const;
  /// h(d) for a unit direction from the vertex to the eye.
  Eigen::VectorXf coefficients(const Eigen::Vector3f& direction) const;
};

/// A mesh of which nothing is known yet but, perhaps, from where its images were taken.
std::shared_ptr<const ModelSnapshot> bare_mesh(std::shared_ptr<const Mesh> mesh, std::vector<PosedCamera> cameras);

/// A surface light field as it is captured: a patch per ring. Unchanged rings are shared between snapshots; a ring that
/// no image has reached is null.
class SurfaceLightFieldSnapshot : public LightFieldSnapshot {
 public:
  SurfaceLightFieldSnapshot(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const VertexRings> rings,
                            std::vector<std::shared_ptr<const RingSnapshot>> ring_data, std::uint64_t version,
                            ExposureField exposure = {}, std::vector<PosedCamera> cameras = {});

  SnapshotFigures figures() const override;
  std::size_t memory_bytes() const override;
  std::shared_ptr<const ModelSnapshot> filled() const override;
  CompressedModel compressed(const CompressionTarget& target) const override;
  void save(const std::filesystem::path& folder, const ModelMetadata& metadata,
            const StepsDone& progress) const override;

  const std::vector<std::shared_ptr<const RingSnapshot>>& ring_data() const { return ring_data_; }

  std::size_t patch_count() const override { return ring_data_.size(); }
  std::shared_ptr<const SurfacePatch> patch(std::size_t index) const override { return ring_data_[index]; }
  PatchCorner corner(std::size_t triangle, int corner) const override;
  Eigen::MatrixXf coefficients_for(const Eigen::Vector3d& eye) const override;
  std::shared_ptr<const LightFieldSnapshot> with_patches(
      const std::vector<std::shared_ptr<const SurfacePatch>>& patches) const override;
  const RingViews* seen_ring(std::size_t vertex) const override;
  double ring_variation(std::size_t vertex) const override;
  int max_rank() const override;
  float common_sill() const override { return common_sill_; }

 private:
  std::vector<std::shared_ptr<const RingSnapshot>> ring_data_;
  float common_sill_;
};

}  // namespace sheen
