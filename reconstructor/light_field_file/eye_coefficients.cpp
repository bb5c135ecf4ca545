// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/eye_coefficients.h"

#include <algorithm>
#include <utility>

#include "reconstructor/light_field_file/in_blocks.h"
#include "reconstructor/numerics/view_kriging.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {
namespace {

std::shared_ptr<const VertexViews> vertex_views(const CompactModel& model, KrigingSystem system,
                                                const ViewKriging& kriging, const Eigen::Vector3f& normal) {
  auto views = std::make_shared<VertexViews>();
  views->directions = std::move(system.directions);
  views->reliability = std::move(system.reliability);
  views->kernel = system.kernel;
  if (kriging.has_drift()) {
    views->reflection = model.reflection;
    views->believed = kriging.believed_drift();
  }
  views->frame = hemisphere_frame(normal);
  views->best_cosine = views->directions.cols() > 0 ? (normal.transpose() * views->directions).maxCoeff() : -1;
  return views;
}

}  // namespace

EyeCoefficients::EyeCoefficients(CompactModel& model, const ForEach& for_each)
    : mesh_(model.mesh), columns_(model.shapes.columns()), interpolants_(model.mesh->vertices.size()) {
  for (const Patch& patch : model.patches) terms_.push_back(static_cast<std::uint16_t>(patch.coefficients.rows()));
  for (const std::uint16_t terms : terms_) max_terms_ = std::max(max_terms_, int{terms});
  const PatchShapes& shapes = model.shapes;
  for (std::uint32_t p = 0; p < shapes.patches.size(); ++p)
    for (std::size_t i = 0; i < shapes.patches[p].vertices.size(); ++i) {
      Interpolant& here = interpolants_[shapes.patches[p].vertices[i]];
      here.columns.push_back(shapes.first_column[p] + static_cast<std::uint32_t>(i));
      here.patches.push_back(p);
    }
  const std::vector<Eigen::Vector3f> normals = vertex_normals(*mesh_);
  in_blocks(interpolants_.size(), 16, for_each, [&](std::size_t v) {
    if (model.drawn_by(v)) interpolate_at(model, v, normals[model.source[v]]);
  });
  for (Patch& patch : model.patches) patch.coefficients.resize(0, 0);
}

void EyeCoefficients::interpolate_at(const CompactModel& model, std::size_t v, const Eigen::Vector3f& normal) {
  const CompactVertex& vertex = *model.drawn_by(v);
  KrigingSystem system = kriging_system(model, vertex, normal);
  Eigen::Index terms = 0;
  Interpolant& here = interpolants_[v];
  for (const std::uint32_t p : here.patches) terms += terms_[p];
  Eigen::MatrixXf coefficients(terms, system.directions.cols());
  Eigen::Index first = 0;
  for (const std::uint32_t p : here.patches) {
    const Patch& patch = model.patches[p];
    const std::vector<Eigen::Index> at = places(vertex, patch_images(model, model.shapes.patches[p]));
    for (std::size_t j = 0; j < at.size(); ++j)
      coefficients.col(static_cast<Eigen::Index>(j)).segment(first, terms_[p]) = patch.coefficients.col(at[j]);
    first += terms_[p];
  }
  const ViewKriging kriging(system.directions, system.reliability, system.kernel, system.drift);
  ViewInterpolant interpolant = kriging.of(coefficients);
  here.views = vertex_views(model, std::move(system), kriging, normal);
  here.weights = PackedColumns<float>::fixed_point(interpolant.weights.transpose());
  here.mean = std::move(interpolant.mean);
  here.drift = std::move(interpolant.drift);
}

Eigen::MatrixXf EyeCoefficients::at(const Eigen::Vector3d& eye, const ForEach& for_each) const {
  Eigen::MatrixXf coefficients = Eigen::MatrixXf::Zero(max_terms_, static_cast<Eigen::Index>(columns_));
  in_blocks(interpolants_.size(), 64, for_each, [&](std::size_t v) {
    const Interpolant& interpolant = interpolants_[v];
    if (!interpolant.views) return;
    const Eigen::Vector3f direction = (eye.cast<float>() - mesh_->vertices[v]).normalized();
    Eigen::VectorXf h(interpolant.mean.size());
    const VertexViews& views = *interpolant.views;
    const Eigen::VectorXf k = covariances(views.kernel, views.directions, direction);
    interpolant.weights.inner_products(k, h);
    h += interpolant.mean;
    if (interpolant.drift.size() > 0) h += views.reflected(direction, k) * interpolant.drift;
    Eigen::Index first = 0;
    for (std::size_t i = 0; i < interpolant.patches.size(); ++i) {
      const Eigen::Index terms = terms_[interpolant.patches[i]];
      coefficients.col(interpolant.columns[i]).head(terms) = h.segment(first, terms);
      first += terms;
    }
  });
  return coefficients;
}

std::size_t EyeCoefficients::bytes() const {
  std::size_t bytes = 0;
  for (const Interpolant& interpolant : interpolants_)
    bytes += interpolant.weights.bytes() +
             sizeof(float) * static_cast<std::size_t>(interpolant.mean.size() + interpolant.drift.size());
  return bytes;
}

}  // namespace sheen
