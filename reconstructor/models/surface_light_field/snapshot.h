// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/models/surface_light_field/reflection_drift.h"
#include "reconstructor/numerics/view_kriging.h"
#include "reconstructor/radiance/exposure_field.h"
#include "reconstructor/surface/vertex_ring.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {

/// Share of a ring's images that showed a sample, in 255ths; 0 only where none did, and no more than 255.
std::uint8_t shown_share(int showed_it, int images);
/// What such a share says of the sample. The one place where the states are told apart.
SampleState sample_state(std::uint8_t shown);

/// The light field of one vertex ring, factorised (000 sec. 4.1): encoded value of row i seen from direction d =
/// sum_r basis(i, r) * h_r(d), with the view functions h_r interpolated by kriging:
/// h(d) = mean + drift * reflection(d mirrored about the normal) + sum_j weights.col(j) * k(angle(d,
/// directions.col(j))).
/// Values are sRGB-encoded (`srgb_encode`); the sum over a triangle's rings is decoded once, at the end.
struct RingSnapshot {
  Eigen::MatrixXf basis;        ///< rows (3 * ring samples) x rank
  Eigen::Matrix3Xf directions;  ///< unit vectors from the vertex to the cameras, object frame; a column a view
  Eigen::MatrixXf weights;      ///< rank x views: kriging in its dual form
  Eigen::VectorXf mean;         ///< rank
  Eigen::VectorXf drift;        ///< rank: of the reflection that all rings share; empty where the ring does without
  std::shared_ptr<const ReflectionDrift> reflection;  ///< null where `drift` is empty
  ViewKernel kernel;
  /// Where views are interpolated as the paper does it, for comparison: `weights` are the views' own coefficients then,
  /// and mean and drift are none. Null for kriging.
  std::shared_ptr<const ViewTriangulation> triangulation;
  Eigen::Matrix3f frame;            ///< of the vertex's hemisphere
  std::vector<std::uint8_t> shown;  ///< per sample: share of the ring's images that showed it (`shown_share`)
  float sill = 0;                   ///< mean square a value: how much it varies with the view (`ViewInterpolant::sill`)
  float residual = 0;               ///< psi_p: smoothed relative projection error of new images, 0..1
  float best_cosine = 0;            ///< of the most frontal view: cos of the angle to the vertex normal
  int views_folded = 0;             ///< images folded in, thinned ones included

  /// Takes over mean, weights, drift and sill. The basis and `shown` must be there already. `shared`: the reflection
  /// that the interpolant's drift is of, if it has one.
  void set_interpolation(ViewInterpolant interpolant, const ViewKernel& view_kernel,
                         std::shared_ptr<const ReflectionDrift> shared);

  /// Interpolates the views' coefficients (rank x views) over the Delaunay triangulation of their directions instead.
  void set_triangulation(const Eigen::MatrixXf& coefficients);

  int rank() const { return static_cast<int>(basis.cols()); }
  SampleState state(int sample) const { return sample_state(shown[sample]); }
  /// h(d) for a unit direction from the vertex to the eye.
  Eigen::VectorXf coefficients(const Eigen::Vector3f& direction) const;
};

/// Immutable surface light field. Unchanged rings are shared between snapshots; a ring that no image has reached is
/// null.
class SurfaceLightFieldSnapshot : public ModelSnapshot {
 public:
  SurfaceLightFieldSnapshot(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const VertexRings> rings,
                            std::vector<std::shared_ptr<const RingSnapshot>> ring_data, std::uint64_t version,
                            ExposureField exposure = {});

  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override;
  const std::shared_ptr<const Mesh>& shared_mesh() const override { return mesh_; }
  std::uint64_t version() const override { return version_; }
  bool empty() const override { return max_rank() == 0; }
  SnapshotFigures figures() const override;
  std::shared_ptr<const ModelSnapshot> filled() const override;
  ViewAdvice advise_next_view(const Eigen::Vector3d& eye) const override;
  void save(const std::filesystem::path& folder, const ModelMetadata& metadata,
            const StepsDone& progress) const override;

  const std::shared_ptr<const VertexRings>& shared_rings() const { return rings_; }
  const VertexRings& rings() const { return *rings_; }
  const std::vector<std::shared_ptr<const RingSnapshot>>& ring_data() const { return ring_data_; }
  const ExposureField& exposure() const { return exposure_; }
  float common_sill() const { return common_sill_; }  ///< mean of the rings' sills
  int max_rank() const;

  /// View coefficients of every ring for this eye: max_rank() x vertices, zero-padded. What a GPU needs a frame.
  Eigen::MatrixXf coefficients_for(const Eigen::Vector3d& eye) const;
  std::vector<SurfaceQuality> quality_for(const Eigen::Vector3d& eye) const;  ///< per triangle

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const VertexRings> rings_;
  std::vector<std::shared_ptr<const RingSnapshot>> ring_data_;
  std::uint64_t version_;
  ExposureField exposure_;
  float common_sill_;
};

}  // namespace sheen
