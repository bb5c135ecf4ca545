// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/edge_blending.h"

#include <algorithm>
#include <vector>

#include "reconstructor/light_field_file/triangle_edges.h"

namespace sheen {
namespace {

/// The samples of a triangle along one of its edges, in the edge's direction, as they stand in its patch.
std::vector<Eigen::Index> samples_along(const CompactModel& model, const TriangleEdge& edge) {
  const int n = model.maps->resolution(edge.triangle);
  std::vector<Eigen::Index> samples;
  for (int k = 0; k < n; ++k) {
    int weight[3] = {0, 0, 0};  // of the corners
    weight[edge.from] = n - 1 - k;
    weight[edge.to] = k;
    samples.push_back(Eigen::Index{model.shapes.first_sample[edge.triangle]} + lattice_index(n, weight[1], weight[2]));
  }
  return samples;
}

/// Rows of a map along an edge: 3 x samples.
Eigen::Matrix3Xf along(const Eigen::Ref<const Eigen::VectorXf>& map, const std::vector<Eigen::Index>& samples) {
  Eigen::Matrix3Xf values(3, static_cast<Eigen::Index>(samples.size()));
  for (std::size_t k = 0; k < samples.size(); ++k)
    values.col(static_cast<Eigen::Index>(k)) = map.segment<3>(3 * samples[k]);
  return values;
}

/// At so many places, evenly spread.
Eigen::Matrix3Xf resampled(const Eigen::Matrix3Xf& values, Eigen::Index places) {
  if (values.cols() == places) return values;
  Eigen::Matrix3Xf out(3, places);
  for (Eigen::Index k = 0; k < places; ++k) {
    const float at = static_cast<float>(k) * static_cast<float>(values.cols() - 1) / static_cast<float>(places - 1);
    const Eigen::Index low = std::min(static_cast<Eigen::Index>(at), values.cols() - 2);
    const float fraction = at - static_cast<float>(low);
    out.col(k) = (1 - fraction) * values.col(low) + fraction * values.col(low + 1);
  }
  return out;
}

void blend(Eigen::Ref<Eigen::VectorXf> map_a, const std::vector<Eigen::Index>& a, Eigen::Ref<Eigen::VectorXf> map_b,
           const std::vector<Eigen::Index>& b) {
  const Eigen::Matrix3Xf values_a = along(map_a, a), values_b = along(map_b, b);
  const Eigen::Matrix3Xf mean_a = (values_a + resampled(values_b, values_a.cols())) / 2,
                         mean_b = (values_b + resampled(values_a, values_b.cols())) / 2;
  for (std::size_t k = 0; k < a.size(); ++k) map_a.segment<3>(3 * a[k]) = mean_a.col(static_cast<Eigen::Index>(k));
  for (std::size_t k = 0; k < b.size(); ++k) map_b.segment<3>(3 * b[k]) = mean_b.col(static_cast<Eigen::Index>(k));
}

}  // namespace

EdgeBlending::EdgeBlending(const CompactModel& model) : inside_(model.shapes.patches.size()) {
  const std::vector<TriangleEdge> edges = triangle_edges(*model.mesh);
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const TriangleEdge &a = edges[i], &b = edges[i + 1];
    if (!a.same_place(b)) continue;
    const bool odd = (i > 0 && edges[i - 1].same_place(a)) || (i + 2 < edges.size() && edges[i + 2].same_place(b));
    if (odd) continue;  // more than two triangles: it is not known which belong together
    const std::uint32_t patch_a = model.shapes.patch_of[a.triangle], patch_b = model.shapes.patch_of[b.triangle];
    if (patch_a == patch_b) inside_[patch_a].push_back(pairs_.size());
    pairs_.push_back({patch_a, patch_b, samples_along(model, a), samples_along(model, b)});
  }
}

void EdgeBlending::blend_means(std::vector<Patch>& patches) const {
  for (const Pair& pair : pairs_) {
    Patch &of_a = patches[pair.patch_a], &of_b = patches[pair.patch_b];
    if (of_a.mean.size() > 0 && of_b.mean.size() > 0) blend(of_a.mean, pair.a, of_b.mean, pair.b);
  }
}

void EdgeBlending::blend_terms(std::size_t patch, Eigen::Ref<Eigen::MatrixXf> basis) const {
  for (const std::size_t pair : inside_[patch])
    for (Eigen::Index k = 0; k < basis.cols(); ++k) blend(basis.col(k), pairs_[pair].a, basis.col(k), pairs_[pair].b);
}

}  // namespace sheen
