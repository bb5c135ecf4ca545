// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/patch_snapshot.h"

#include <algorithm>
#include <utility>

namespace sheen {

void VertexInterpolant::set_interpolation(ViewInterpolant interpolant, const ViewKernel& view_kernel,
                                          std::shared_ptr<const ReflectionDrift> shared, std::size_t samples) {
  kernel = view_kernel;
  mean = std::move(interpolant.mean);
  weights = std::move(interpolant.weights);
  drift = std::move(interpolant.drift);
  if (drift.size() > 0) reflection = std::move(shared);
  const double values = 3.0 * static_cast<double>(std::max<std::size_t>(samples, 1));
  constexpr double kMostSill = 1e6;  // of images without bounds: what files hold, and as bad as can be
  sill = static_cast<float>(std::min(interpolant.sill / values, kMostSill));
}

void VertexInterpolant::set_triangulation(const Eigen::MatrixXf& coefficients) {
  triangulation = std::make_shared<ViewTriangulation>(triangulate_views(frame, directions));
  weights = coefficients;
  mean.setZero();
  drift.resize(0);
  reflection.reset();
}

Eigen::VectorXf VertexInterpolant::coefficients(const Eigen::Vector3f& direction) const {
  return CoefficientsAtVertex(direction).of(*this);
}

bool same_views(const VertexInterpolant& a, const VertexInterpolant& b) {
  return a.directions.cols() == b.directions.cols() && a.directions == b.directions && a.reliability == b.reliability;
}

Eigen::VectorXf CoefficientsAtVertex::of(const VertexInterpolant& vertex) {
  if (vertex.triangulation)
    return vertex.weights * delaunay_weights(*vertex.triangulation, hemisphere_point(vertex.frame, direction_));
  if (!last_ || last_->kernel != vertex.kernel || !same_views(*last_, vertex)) {
    covariances_ = covariances(vertex.kernel, vertex.directions, direction_);
    last_ = &vertex;
  }
  Eigen::VectorXf h = vertex.mean;
  h.noalias() += vertex.weights * covariances_;
  if (!vertex.reflection) return h;
  const Eigen::Vector3f normal = vertex.frame.row(2);
  if (reflection_ != vertex.reflection.get() || normal != normal_) {
    reflected_ = vertex.reflection->at(direction_, normal);
    reflection_ = vertex.reflection.get();
    normal_ = normal;
  }
  h += reflected_ * vertex.drift;
  return h;
}

std::size_t VertexInterpolant::bytes() const {
  const Eigen::Index values = weights.size() + mean.size() + drift.size() + directions.size() + reliability.size();
  return sizeof(*this) + static_cast<std::size_t>(values) * sizeof(float);
}

bool PatchSnapshot::seen() const {
  return rank() > 0 && !vertices.empty() && vertices.front().directions.cols() > 0 && shown_samples() > 0;
}

std::size_t PatchSnapshot::shown_samples() const {
  return static_cast<std::size_t>(
      std::count_if(shown.begin(), shown.end(), [](std::uint8_t share) { return share > 0; }));
}

std::size_t PatchSnapshot::bytes() const {
  std::size_t bytes = static_cast<std::size_t>(basis.size()) * sizeof(float) + shown.size();
  for (const VertexInterpolant& vertex : vertices) bytes += vertex.bytes();
  return bytes;
}

}  // namespace sheen
