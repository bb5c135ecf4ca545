// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/page/wasm/page_model.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/base/errors.h"
#include "reconstructor/light_field_file/triangle_edges.h"
#include "reconstructor/render/gl/opening_view.h"

namespace sheen {
namespace {

constexpr float kGreyLevels = 255, kMostInByte = 255, kMostSigned = 127;
constexpr std::size_t kTexelBytes = 4, kBlockRows = 32;
constexpr std::uint32_t kNothingKnown = UINT32_MAX;

std::uint32_t bits_of(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

std::uint8_t byte_of(float value) {
  return static_cast<std::uint8_t>(std::clamp(value, 0.0f, kMostInByte) + 0.5f);
}

std::size_t whole_rows(std::size_t texels) {
  return (texels + PageModel::kRowTexels - 1) / PageModel::kRowTexels * PageModel::kRowTexels;
}

template <typename Vector, typename Numbers>
void append(const Vector& vector, Numbers& numbers) {
  for (Eigen::Index i = 0; i < vector.size(); ++i)
    numbers.push_back(static_cast<typename Numbers::value_type>(vector[i]));
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

std::vector<double> PageModel::scene() const {
  const BoundingSphere sphere = bounding_sphere(mesh());
  const auto view = opening_view(model().cameras, sphere.centre).value_or(OpeningView{{0, 0, 1}, {0.6, -0.7, 0.4}});
  std::vector<double> scene;
  append(sphere.centre, scene);
  scene.push_back(sphere.radius);
  append(view.up, scene);
  append(view.direction.normalized(), scene);
  append(mesh().origin, scene);
  scene.push_back(brightest_drawn(model()));
  return scene;
}

std::vector<float> PageModel::cameras() const {
  std::vector<float> numbers;
  for (const PosedCamera& from : model().cameras) {
    append(camera_centre(from.camera_from_object), numbers);
    const Eigen::Matrix3d axes = from.camera_from_object.rotation.toRotationMatrix();
    for (int axis = 0; axis < 3; ++axis) append(axes.row(axis), numbers);
    numbers.push_back(static_cast<float>(0.5 * from.camera.width / from.camera.fx));
    numbers.push_back(static_cast<float>(0.5 * from.camera.height / from.camera.fy));
  }
  return numbers;
}

std::vector<std::uint32_t> PageModel::edges() const {
  const std::vector<TriangleEdge> all = triangle_edges(mesh());
  std::vector<std::uint32_t> numbers;
  for (std::size_t first = 0, end = 0; first < all.size(); first = end) {
    while (end < all.size() && all[end].same_place(all[first])) ++end;
    const std::uint32_t other = end - first == 2 ? all[first + 1].triangle : all[first].triangle;
    numbers.insert(numbers.end(), {all[first].low, all[first].high, all[first].triangle, other});
  }
  return numbers;
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
  means_.assign(kTexelBytes * whole_rows(quantised.model.maps->total_samples()), 0);
  mean_ranges_.assign(patches.size(), {0, 1});
  std::uint8_t* texel = means_.data();
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const Eigen::VectorXf& mean = patches[i].mean;
    const std::vector<SampleState>& states = quantised.model.patches[i].state;
    if (mean.size() > 0) mean_ranges_[i] = {mean.minCoeff(), std::max(mean.maxCoeff() - mean.minCoeff(), 1e-6f)};
    const float low = mean_ranges_[i].x(), step = kMostInByte / mean_ranges_[i].y();
    for (std::size_t s = 0; s < states.size(); ++s, texel += kTexelBytes) {
      const auto row = static_cast<Eigen::Index>(3 * s);
      for (int c = 0; mean.size() > 0 && c < 3; ++c) texel[c] = byte_of(step * (mean[row + c] - low));
      texel[3] = static_cast<std::uint8_t>(127 * static_cast<int>(states[s]));
    }
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
    const Eigen::Vector2f range = mean_ranges_[place.patch] / kGreyLevels;
    const Triangle& corners = mesh().triangles[t];
    places_.insert(places_.end(), corners.begin(), corners.end());
    places_.push_back(static_cast<std::uint32_t>(quantised.model.maps->resolution(t)));
    places_.insert(places_.end(), place.columns.begin(), place.columns.end());
    places_.push_back(static_cast<std::uint32_t>(first_sample[place.patch]) + place.first_sample);
    places_.push_back(static_cast<std::uint32_t>(first_texel[place.patch]) + place.first_sample * terms);
    places_.push_back(quantised.patches[place.patch].known ? terms : kNothingKnown);
    places_.insert(places_.end(), {bits_of(range.x()), bits_of(range.y())});
  }
}

const std::vector<std::uint8_t>& PageModel::next_terms() {
  constexpr std::size_t kBlock = kBlockRows * kRowTexels * kTexelBytes;
  while (texels_.size() < kBlock && next_patch_ < model_.patches.size()) pack_terms(next_patch_++);
  if (next_patch_ == model_.patches.size()) texels_.resize(kTexelBytes * whole_rows(texels_.size() / kTexelBytes));
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
  texels_.resize(first + kTexelBytes * terms * static_cast<std::size_t>(basis.rows() / 3));
  for (Eigen::Index k = 0; k < basis.cols(); ++k) {
    const float largest = std::max(basis.col(k).cwiseAbs().maxCoeff(), 1e-12f);
    const float step = kMostSigned / largest;
    std::uint8_t* texel = texels_.data() + first + kTexelBytes * static_cast<std::size_t>(k);
    for (Eigen::Index row = 0; row < basis.rows(); row += 3, texel += kTexelBytes * terms)
      for (int c = 0; c < 3; ++c) texel[c] = byte_of(128 + step * basis(row + c, k));
    patch.coefficients.row(k) *= kMostInByte / kMostSigned * largest / kGreyLevels;
  }
  model_.model.patches[index].coefficients = std::move(patch.coefficients);
}

void PageModel::look_from(const Eigen::Vector3d& eye) {
  if (!coefficients_) throw Error("the model is not whole yet");
  seen_ = coefficients_->at(eye, one_after_the_other);
}

}  // namespace sheen
