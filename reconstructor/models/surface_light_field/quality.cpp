// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/quality.h"

#include <algorithm>
#include <cmath>

#include "reconstructor/models/surface_light_field/light_field_snapshot.h"

namespace sheen {
namespace {

constexpr float kCommonViews = 1;  // images that the other vertices' sills count for

}  // namespace

SurfaceQuality assess_vertex(const SeenVertex& vertex, const Eigen::Vector3f& direction, float common_sill) {
  SurfaceQuality quality;
  quality.seen = true;
  const VertexViews& from = *vertex.views;
  const auto views = static_cast<float>(from.directions.cols());
  const float sill = (views * vertex.sill + kCommonViews * common_sill) / (views + kCommonViews);
  quality.error = std::sqrt(sill * prediction_variance(from.directions, from.kernel, direction));
  quality.nearest_cosine = (from.directions.transpose() * direction).maxCoeff();
  quality.best_cosine = from.best_cosine;
  return quality;
}

SurfaceQuality combine(const SurfaceQuality& a, const SurfaceQuality& b, const SurfaceQuality& c) {
  if (!a.seen || !b.seen || !c.seen) return {};
  const bool shape_guessed = int(a.shape_guessed) + int(b.shape_guessed) + int(c.shape_guessed) > 1;
  return {true, (a.error + b.error + c.error) / 3, std::max({a.nearest_cosine, b.nearest_cosine, c.nearest_cosine}),
          std::max({a.best_cosine, b.best_cosine, c.best_cosine}), shape_guessed};
}

}  // namespace sheen
