// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/parallel/for_each.h"
#include "reconstructor/light_field_file/compact_model.h"
#include "reconstructor/light_field_file/vertex_views.h"
#include "reconstructor/numerics/packed_columns.h"

namespace sheen {

/// What an eye needs beside the surface maps: for each vertex of a mesh the kriging of the coefficients of its patches.
class EyeCoefficients {
 public:
  /// Takes the coefficients of its patches out of the model; all else stays there.
  EyeCoefficients(CompactModel& model, const ForEach& for_each);

  /// Null where nothing is known of a vertex.
  const std::shared_ptr<const VertexViews>& views(std::size_t vertex) const { return interpolants_[vertex].views; }
  int max_terms() const { return max_terms_; }  ///< of all patches, without their means
  std::size_t bytes() const;

  /// View coefficients for this eye (object frame): max_terms() x columns (`TrianglePlace::columns`), zero-padded.
  Eigen::MatrixXf at(const Eigen::Vector3d& eye, const ForEach& for_each) const;

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
  std::size_t columns_;
  std::vector<std::uint16_t> terms_;       ///< per patch
  std::vector<Interpolant> interpolants_;  ///< per vertex
  int max_terms_ = 0;
};

}  // namespace sheen
