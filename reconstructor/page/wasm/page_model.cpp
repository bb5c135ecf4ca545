// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/page/wasm/page_model.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/base/errors.h"

namespace sheen {
namespace {

constexpr float kGreyLevels = 255;
constexpr std::size_t kBlockRows = 32;
constexpr std::uint32_t kNothingKnown = UINT32_MAX;

std::uint32_t bits_of(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

std::size_t whole_rows(std::size_t texels) {
  return (texels + PageModel::kRowTexels - 1) / PageModel::kRowTexels * PageModel::kRowTexels;
}

}  // namespace

PageModel::Stage PageModel::read(std::string_view bytes, bool whole) {
  constexpr std::size_t kFirstChunk = 12;  // behind magic and version
  if (ended_ || (bytes.size() < kFirstChunk && !whole)) return Stage::kNothing;
  while (const auto chunk = reader_.read_next(bytes)) {
    if (*chunk == "MESH") return Stage::kMesh;
    if (*chunk == "L000") {
      make_means(reader_.read());
      return Stage::kMeans;
    }
  }
  if (!whole) return Stage::kNothing;
  model_ = std::move(reader_).finish();
  ended_ = true;
  make_means(model_);
  blending_.emplace(model_.model);
  return Stage::kTerms;
}

void PageModel::make_means(const QuantisedModel& quantised) {
  const FileLayout& layout = quantised.layout;
  std::vector<Patch> patches(quantised.patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (!quantised.patches[i].known) continue;
    patches[i].mean.resize(3 * Eigen::Index{quantised.model.shapes.patches[i].samples});
    dequantise_map(quantised.patches[i].mean, layout.resolutions[i], layout.steps[i], patches[i].mean);
  }
  EdgeBlending(quantised.model).blend_means(patches);
  means_.assign(kPageTexelBytes * whole_rows(quantised.model.maps->total_samples()), 0);
  mean_ranges_.clear();
  std::uint8_t* texels = means_.data();
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const std::vector<SampleState>& states = quantised.model.patches[i].state;
    mean_ranges_.push_back(pack_means(patches[i].mean, states, texels));
    texels += kPageTexelBytes * states.size();
  }
  make_places(quantised);
}

void PageModel::make_places(const QuantisedModel& quantised) {
  const PatchShapes& shapes = quantised.model.shapes;
  std::vector<std::size_t> first_sample, first_texel;  // per patch
  std::size_t samples = 0;
  term_texels_ = 0;
  for (std::size_t i = 0; i < shapes.patches.size(); ++i) {
    first_sample.push_back(samples);
    first_texel.push_back(term_texels_);
    samples += shapes.patches[i].samples;
    term_texels_ += shapes.patches[i].samples * quantised.patches[i].terms.size();
  }
  places_.clear();
  for (std::size_t t = 0; t < mesh().triangles.size(); ++t) {
    const TrianglePlace place = shapes.place(t);
    const auto terms = static_cast<std::uint32_t>(quantised.patches[place.patch].terms.size());
    const MeanRange& range = mean_ranges_[place.patch];
    const Triangle& corners = mesh().triangles[t];
    places_.insert(places_.end(), corners.begin(), corners.end());
    places_.push_back(static_cast<std::uint32_t>(quantised.model.maps->resolution(t)));
    places_.insert(places_.end(), place.columns.begin(), place.columns.end());
    places_.push_back(static_cast<std::uint32_t>(first_sample[place.patch]) + place.first_sample);
    places_.push_back(static_cast<std::uint32_t>(first_texel[place.patch]) + place.first_sample * terms);
    places_.push_back(quantised.patches[place.patch].known ? terms : kNothingKnown);
    places_.insert(places_.end(), {bits_of(range.low / kGreyLevels), bits_of(range.width / kGreyLevels)});
  }
}

const std::vector<std::uint8_t>& PageModel::next_terms() {
  constexpr std::size_t kBlock = kBlockRows * kRowTexels * kPageTexelBytes;
  while (texels_.size() < kBlock && next_patch_ < model_.patches.size()) pack_terms(next_patch_++);
  if (next_patch_ == model_.patches.size())
    texels_.resize(kPageTexelBytes * whole_rows(texels_.size() / kPageTexelBytes));
  const auto end = texels_.begin() + static_cast<std::ptrdiff_t>(std::min(texels_.size(), kBlock));
  block_.assign(texels_.begin(), end);
  texels_.erase(texels_.begin(), end);
  if (block_.empty() && !coefficients_) {
    blending_.reset();
    texels_ = {};
    coefficients_.emplace(model_.model, one_after_the_other);
    model_.layout = {};
  }
  return block_;
}

void PageModel::pack_terms(std::size_t index) {
  Patch patch = dequantise(model_.patches[index], model_.layout.resolutions[index], model_.layout.plans[index],
                           model_.layout.steps[index]);
  model_.patches[index] = {};
  Eigen::MatrixXf& basis = patch.basis.exact();
  blending_->blend_terms(index, basis);
  const auto terms = static_cast<std::size_t>(basis.cols());
  const std::size_t first = texels_.size();
  texels_.resize(first + kPageTexelBytes * terms * static_cast<std::size_t>(basis.rows() / 3));
  for (Eigen::Index k = 0; k < basis.cols(); ++k) {
    const float largest =
        pack_term(basis.col(k), terms, texels_.data() + first + kPageTexelBytes * static_cast<std::size_t>(k));
    patch.coefficients.row(k) *= amount_per_coefficient(largest) / kGreyLevels;
  }
  model_.model.patches[index].coefficients = std::move(patch.coefficients);
}

void PageModel::look_from(const Eigen::Vector3d& eye) {
  if (!coefficients_) throw Error("the model is not whole yet");
  seen_ = coefficients_->at(eye, one_after_the_other);
}

}  // namespace sheen
