// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "reconstructor/light_field_file/compact_model.h"

namespace sheen {

/// Two triangles with a common edge have the same colours along it, but quantised apart they differ by a step or so: a
/// seam. Each takes the mean of both there: of the means everywhere, of the terms inside a patch, where both have the
/// same ones.
class EdgeBlending {
 public:
  explicit EdgeBlending(const CompactModel& model);

  void blend_means(std::vector<Patch>& patches) const;  ///< of the model
  /// Of a patch, whose maps are columns: rows 3 * sample + channel.
  void blend_terms(std::size_t patch, Eigen::Ref<Eigen::MatrixXf> basis) const;

 private:
  /// The samples of two triangles along their edge, in its direction, as they stand in their patches.
  struct Pair {
    std::uint32_t patch_a, patch_b;
    std::vector<Eigen::Index> a, b;
  };
  std::vector<Pair> pairs_;
  std::vector<std::vector<std::size_t>> inside_;  ///< per patch: pairs of its own triangles
};

}  // namespace sheen
