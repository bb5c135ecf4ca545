// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "reconstructor/models/surface_light_field/light_field_snapshot.h"
#include "reconstructor/numerics/packed_columns.h"
#include "reconstructor/numerics/view_kriging.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {

/// View functions h_r of a patch at one of its vertices, interpolated by kriging between the patch's views as they are
/// seen from the vertex:
/// h(d) = mean + drift * reflection(d mirrored about the normal, as far as it is believed) + sum_j weights.row(j) *
/// k(angle(d, directions.col(j))).
struct VertexInterpolant : SeenVertex {
  PackedColumns<float> weights;  ///< views x rank: kriging in its dual form, in fixed point
  Eigen::VectorXf mean;          ///< rank
  Eigen::VectorXf drift;         ///< rank: of the reflection that all share; empty where the vertex does without
  /// Where views are interpolated as the paper does it, for comparison: `weights` are the views' own coefficients then,
  /// and mean and drift are none. Null for kriging.
  std::shared_ptr<const ViewTriangulation> triangulation;

  /// Takes over mean, weights, drift and sill of a patch of which images showed so many `samples`.
  void set_interpolation(ViewInterpolant interpolant, std::size_t samples);

  /// Interpolates the views' coefficients (rank x views) over the Delaunay triangulation of their directions instead.
  void set_triangulation(const Eigen::MatrixXf& coefficients);
  /// The same where `weights` are these already.
  void triangulate();

  std::size_t bytes() const;  ///< without the views, which patches share
  /// h(d) for a unit direction from the vertex to the eye.
  Eigen::VectorXf coefficients(const Eigen::Vector3f& direction) const;
  /// Their mean over the views.
  Eigen::VectorXf average_coefficients() const;
};

/// `VertexInterpolant::coefficients` of patches that share a vertex, for one direction: what kernel and reflection are
/// there is found once for patches that share their views and come one after the other.
class CoefficientsAtVertex {
 public:
  /// `direction`: unit, from the vertex to the eye.
  explicit CoefficientsAtVertex(const Eigen::Vector3f& direction) : direction_(direction) {}

  /// `h`: rank.
  void of(const VertexInterpolant& vertex, Eigen::Ref<Eigen::VectorXf> h);

 private:
  Eigen::Vector3f direction_;
  const VertexViews* views_ = nullptr;  ///< of which the following is
  Eigen::VectorXf covariances_;
  float reflected_ = 0;
};

/// The light field of one patch, factorized (000 sec. 4.1): surface maps of its triangles, and view functions at each
/// of its vertices.
struct PatchSnapshot : SurfacePatch {
  std::vector<VertexInterpolant> vertices;  ///< as `PatchShape::vertices`

  bool seen() const;  ///< some image showed something of it
  std::size_t shown_samples() const;
  std::size_t bytes() const;
};

}  // namespace sheen
