// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/parallel/for_each.h"
#include "reconstructor/light_field_file/compact_model.h"
#include "reconstructor/light_field_file/surface_patch.h"
#include "reconstructor/light_field_file/vertex_views.h"
#include "reconstructor/numerics/packed_columns.h"

namespace sheen {

/// A model that is looked at: the surface maps of its patches, and for each vertex the kriging of the coefficients of
/// its patches, which is what an eye needs. A picture is the maps of a triangle's patch times the view coefficients of
/// its corners (`SurfacePatch::colour`), no brighter than `brightest_drawn`.
class LightFieldEvaluator {
 public:
  /// Takes the maps and coefficients of its patches out of the model; all else stays there.
  LightFieldEvaluator(CompactModel& model, const ForEach& for_each);

  /// In the first term the mean map, whose coefficient is 1. Null where nothing is known of a patch.
  const std::vector<std::shared_ptr<const SurfacePatch>>& patches() const { return patches_; }
  const PatchShapes& shapes() const { return shapes_; }
  /// Null where nothing is known of a vertex.
  const std::shared_ptr<const VertexViews>& views(std::size_t vertex) const { return interpolants_[vertex].views; }
  int max_rank() const { return patches_.empty() ? 0 : 1 + max_terms_; }
  std::size_t bytes() const;  ///< of maps and interpolants

  /// View coefficients for this eye (object frame): max_rank() x columns (`TrianglePlace::columns`), zero-padded.
  Eigen::MatrixXf coefficients_for(const Eigen::Vector3d& eye, const ForEach& for_each) const;

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

  std::shared_ptr<const Mesh> mesh_;
  PatchShapes shapes_;
  std::vector<std::shared_ptr<const SurfacePatch>> patches_;
  std::vector<Interpolant> interpolants_;  ///< per vertex
  int max_terms_ = 0;
};

}  // namespace sheen
