// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/light_field_evaluator.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "reconstructor/numerics/view_kriging.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {
namespace {

constexpr float kGreyLevels = 255;

/// A fraction of the patch's images that stands for the state.
std::uint8_t fraction_of(SampleState state) {
  constexpr std::uint8_t kFractions[] = {0, 64, 255};
  return kFractions[static_cast<std::size_t>(state)];
}

/// Of the patch, whose maps are let go of.
std::shared_ptr<const SurfacePatch> take_surface(Patch& patch) {
  if (patch.mean.size() == 0) return nullptr;
  auto surface = std::make_shared<SurfacePatch>();
  Eigen::MatrixXf basis(patch.mean.size(), 1 + patch.basis.cols());
  basis << patch.mean / kGreyLevels, patch.basis.unpacked() / kGreyLevels;
  surface->basis = packed_terms(basis, Eigen::VectorXf::Constant(basis.cols(), kGreyLevels));
  for (const SampleState state : patch.state) surface->shown.push_back(fraction_of(state));
  patch.mean.resize(0);
  patch.basis = {};
  return surface;
}

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

/// So many at a time: one is too little for a task.
void in_blocks(std::size_t count, std::size_t block, const ForEach& for_each,
               const std::function<void(std::size_t)>& work) {
  for_each((count + block - 1) / block, [&](std::size_t b) {
    for (std::size_t i = b * block; i < std::min(count, (b + 1) * block); ++i) work(i);
  });
}

}  // namespace

LightFieldEvaluator::LightFieldEvaluator(CompactModel& model, const ForEach& for_each)
    : mesh_(model.mesh),
      shapes_(model.shapes),
      patches_(model.patches.size()),
      interpolants_(model.mesh->vertices.size()) {
  in_blocks(patches_.size(), 64, for_each, [&](std::size_t p) { patches_[p] = take_surface(model.patches[p]); });
  for (std::uint32_t p = 0; p < shapes_.patches.size(); ++p)
    for (std::size_t i = 0; i < shapes_.patches[p].vertices.size(); ++i) {
      Interpolant& here = interpolants_[shapes_.patches[p].vertices[i]];
      here.columns.push_back(shapes_.first_column[p] + static_cast<std::uint32_t>(i));
      here.patches.push_back(p);
    }
  const std::vector<Eigen::Vector3f> normals = vertex_normals(*mesh_);
  in_blocks(interpolants_.size(), 16, for_each, [&](std::size_t v) {
    if (model.drawn_by(v)) interpolate_at(model, v, normals[model.source[v]]);
  });
  for (Patch& patch : model.patches) {
    max_terms_ = std::max(max_terms_, static_cast<int>(patch.coefficients.rows()));
    patch.coefficients.resize(0, 0);
  }
}

void LightFieldEvaluator::interpolate_at(const CompactModel& model, std::size_t v, const Eigen::Vector3f& normal) {
  const CompactVertex& vertex = *model.drawn_by(v);
  KrigingSystem system = kriging_system(model, vertex, normal);
  Eigen::Index terms = 0;
  Interpolant& here = interpolants_[v];
  for (const std::uint32_t p : here.patches) terms += model.patches[p].coefficients.rows();
  Eigen::MatrixXf coefficients(terms, system.directions.cols());
  Eigen::Index first = 0;
  for (const std::uint32_t p : here.patches) {
    const Patch& patch = model.patches[p];
    const std::vector<Eigen::Index> at = places(vertex, patch_images(model, shapes_.patches[p]));
    for (std::size_t j = 0; j < at.size(); ++j)
      coefficients.col(static_cast<Eigen::Index>(j)).segment(first, patch.coefficients.rows()) =
          patch.coefficients.col(at[j]);
    first += patch.coefficients.rows();
  }
  const ViewKriging kriging(system.directions, system.reliability, system.kernel, system.drift);
  ViewInterpolant interpolant = kriging.of(coefficients);
  here.views = vertex_views(model, std::move(system), kriging, normal);
  here.weights = PackedColumns<float>::fixed_point(interpolant.weights.transpose());
  here.mean = std::move(interpolant.mean);
  here.drift = std::move(interpolant.drift);
}

Eigen::MatrixXf LightFieldEvaluator::coefficients_for(const Eigen::Vector3d& eye, const ForEach& for_each) const {
  Eigen::MatrixXf coefficients = Eigen::MatrixXf::Zero(1 + max_terms_, static_cast<Eigen::Index>(shapes_.columns()));
  coefficients.row(0).setOnes();  // of the mean map
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
      const auto& patch = patches_[interpolant.patches[i]];
      const Eigen::Index terms = patch ? patch->rank() - 1 : 0;
      coefficients.col(interpolant.columns[i]).segment(1, terms) = h.segment(first, terms);
      first += terms;
    }
  });
  return coefficients;
}

std::size_t LightFieldEvaluator::bytes() const {
  std::size_t bytes = 0;
  for (const auto& patch : patches_)
    if (patch) bytes += patch->basis.bytes() + patch->shown.size();
  for (const Interpolant& interpolant : interpolants_)
    bytes += interpolant.weights.bytes() +
             sizeof(float) * static_cast<std::size_t>(interpolant.mean.size() + interpolant.drift.size());
  return bytes;
}

}  // namespace sheen
