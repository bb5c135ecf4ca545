// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "common/parallel/for_each.h"
#include "reconstructor/light_field_file/compact_model.h"
#include "reconstructor/light_field_file/eye_coefficients.h"
#include "reconstructor/light_field_file/surface_patch.h"

namespace sheen {

/// A model that is looked at: the surface maps of its patches, and what an eye needs beside them. A picture is the maps
/// of a triangle's patch times the view coefficients of its corners (`SurfacePatch::colour`), no brighter than
/// `brightest_drawn`.
class LightFieldEvaluator {
 public:
  /// Takes the maps and coefficients of its patches out of the model; all else stays there.
  LightFieldEvaluator(CompactModel& model, const ForEach& for_each);

  /// In the first term the mean map, whose coefficient is 1. Null where nothing is known of a patch.
  const std::vector<std::shared_ptr<const SurfacePatch>>& patches() const { return patches_; }
  const PatchShapes& shapes() const { return shapes_; }
  /// Null where nothing is known of a vertex.
  const std::shared_ptr<const VertexViews>& views(std::size_t vertex) const { return coefficients_.views(vertex); }
  int max_rank() const { return patches_.empty() ? 0 : 1 + coefficients_.max_terms(); }
  std::size_t bytes() const;  ///< of maps and interpolants

  /// View coefficients for this eye (object frame): max_rank() x columns (`TrianglePlace::columns`), zero-padded.
  Eigen::MatrixXf coefficients_for(const Eigen::Vector3d& eye, const ForEach& for_each) const;

 private:
  PatchShapes shapes_;
  std::vector<std::shared_ptr<const SurfacePatch>> patches_;
  EyeCoefficients coefficients_;
};

}  // namespace sheen
