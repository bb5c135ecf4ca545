// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/light_field_evaluator.h"

#include "reconstructor/light_field_file/in_blocks.h"

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

std::vector<std::shared_ptr<const SurfacePatch>> take_surfaces(CompactModel& model, const ForEach& for_each) {
  std::vector<std::shared_ptr<const SurfacePatch>> patches(model.patches.size());
  in_blocks(patches.size(), 64, for_each, [&](std::size_t p) { patches[p] = take_surface(model.patches[p]); });
  return patches;
}

}  // namespace

LightFieldEvaluator::LightFieldEvaluator(CompactModel& model, const ForEach& for_each)
    : shapes_(model.shapes), patches_(take_surfaces(model, for_each)), coefficients_(model, for_each) {}

Eigen::MatrixXf LightFieldEvaluator::coefficients_for(const Eigen::Vector3d& eye, const ForEach& for_each) const {
  const Eigen::MatrixXf terms = coefficients_.at(eye, for_each);
  Eigen::MatrixXf coefficients(1 + terms.rows(), terms.cols());
  coefficients.row(0).setOnes();  // of the mean map
  coefficients.bottomRows(terms.rows()) = terms;
  return coefficients;
}

std::size_t LightFieldEvaluator::bytes() const {
  std::size_t bytes = coefficients_.bytes();
  for (const auto& patch : patches_)
    if (patch) bytes += patch->basis.bytes() + patch->shown.size();
  return bytes;
}

}  // namespace sheen
