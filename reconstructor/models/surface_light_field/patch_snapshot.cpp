// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/patch_snapshot.h"

#include <algorithm>
#include <utility>

namespace sheen {

void VertexInterpolant::set_interpolation(ViewInterpolant interpolant, std::size_t samples) {
  mean = std::move(interpolant.mean);
  weights = PackedColumns<float>::fixed_point(interpolant.weights.transpose());
  drift = std::move(interpolant.drift);
  const double values = 3.0 * static_cast<double>(std::max<std::size_t>(samples, 1));
  constexpr double kMostSill = 1e6;  // of images without bounds: what files hold, and as bad as can be
  sill = static_cast<float>(std::min(interpolant.sill / values, kMostSill));
}

void VertexInterpolant::set_triangulation(const Eigen::MatrixXf& coefficients) {
  weights = PackedColumns<float>::fixed_point(coefficients.transpose());
  triangulate();
}

void VertexInterpolant::triangulate() {
  triangulation = std::make_shared<ViewTriangulation>(triangulate_views(views->frame, views->directions));
  mean.setZero();
  drift.resize(0);
}

Eigen::VectorXf VertexInterpolant::coefficients(const Eigen::Vector3f& direction) const {
  Eigen::VectorXf h(mean.size());
  CoefficientsAtVertex(direction).of(*this, h);
  return h;
}

Eigen::VectorXf VertexInterpolant::average_coefficients() const {
  const Eigen::Index count = views->directions.cols();
  if (count == 0) return mean;
  Eigen::VectorXf sum = Eigen::VectorXf::Zero(mean.size());
  for (Eigen::Index view = 0; view < count; ++view) sum += coefficients(views->directions.col(view));
  return sum / static_cast<float>(count);
}

void CoefficientsAtVertex::of(const VertexInterpolant& vertex, Eigen::Ref<Eigen::VectorXf> h) {
  const VertexViews& views = *vertex.views;
  if (vertex.triangulation) {
    vertex.weights.inner_products(delaunay_weights(*vertex.triangulation, hemisphere_point(views.frame, direction_)),
                                  h);
    return;
  }
  if (views_ != &views) {
    views_ = &views;
    covariances_ = covariances(views.kernel, views.directions, direction_);
    reflected_ = views.reflected(direction_, covariances_);
  }
  vertex.weights.inner_products(covariances_, h);
  h += vertex.mean;
  if (vertex.drift.size() > 0) h += reflected_ * vertex.drift;
}

std::size_t VertexInterpolant::bytes() const {
  return sizeof(*this) + weights.bytes() + sizeof(float) * static_cast<std::size_t>(mean.size() + drift.size());
}

bool PatchSnapshot::seen() const {
  return rank() > 0 && !vertices.empty() && vertices.front().views->directions.cols() > 0 && shown_samples() > 0;
}

std::size_t PatchSnapshot::shown_samples() const {
  return static_cast<std::size_t>(
      std::count_if(shown.begin(), shown.end(), [](std::uint8_t fraction) { return fraction > 0; }));
}

std::size_t PatchSnapshot::bytes() const {
  std::size_t bytes = basis.bytes() + shown.size();
  for (const VertexInterpolant& vertex : vertices) bytes += vertex.bytes();
  return bytes;
}

}  // namespace sheen
