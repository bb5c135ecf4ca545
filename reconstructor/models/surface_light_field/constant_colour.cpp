// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/constant_colour.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/image/color.h"
#include "reconstructor/surface/nearest_seen.h"

namespace sheen {
namespace {

struct ConstantColourSnapshot : public Appearance {
  std::shared_ptr<const Mesh> shape;
  std::shared_ptr<const MapLayout> maps;
  Eigen::Matrix3Xf colour;  ///< encoded; a sample
  std::vector<std::uint8_t> known;
  ExposureField exposure;

  const Mesh& mesh() const override { return *shape; }
  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override;
};

class ConstantColourShader : public ViewShader {
 public:
  ConstantColourShader(const ConstantColourSnapshot& model, float exposure) : model_(model), exposure_(exposure) {}

  SurfaceSample shade(std::uint32_t triangle, float u, float v) const override {
    const LatticeStencil stencil = lattice_stencil(model_.maps->resolution(triangle), u, v);
    Eigen::Vector3f encoded = Eigen::Vector3f::Zero();
    bool measured = false;
    for (int k = 0; k < 3; ++k) {
      const auto s = static_cast<Eigen::Index>(model_.maps->first_sample(triangle) + stencil.index[k]);
      encoded += stencil.weight[k] * model_.colour.col(s);
      measured |= stencil.weight[k] > 0.25f && model_.known[s];
    }
    const Eigen::Vector3f radiance(srgb_decode(encoded.x()), srgb_decode(encoded.y()), srgb_decode(encoded.z()));
    return {exposure_ * radiance, measured ? SampleState::kMeasured : SampleState::kUnseen};
  }
  SurfaceQuality quality(std::uint32_t) const override { return {true, 0, 1, 1}; }  // it claims nothing

 private:
  const ConstantColourSnapshot& model_;
  float exposure_;
};

std::unique_ptr<ViewShader> ConstantColourSnapshot::shader_for(const ViewQuery& query) const {
  return std::make_unique<ConstantColourShader>(*this, exposure.at(query.eye));
}

float log_ratio(float encoded_seen, float encoded_expected) {
  const auto usable = [](float v) { return v > 0.03f && v < 0.97f; };  // black and clipped values tell no gain
  if (!usable(encoded_seen) || !usable(encoded_expected)) return std::numeric_limits<float>::quiet_NaN();
  return std::log(srgb_decode(encoded_seen) / srgb_decode(encoded_expected));
}

/// Where no image showed the surface: the mean of the triangle's seen samples, or, where it has none, that of the
/// triangles round the seen vertex that is nearest to its first corner.
void fill_unseen(ConstantColourSnapshot& snapshot) {
  const std::size_t triangles = snapshot.shape->triangles.size();
  Eigen::Matrix4Xf in_triangle = Eigen::Matrix4Xf::Zero(4, static_cast<Eigen::Index>(triangles));  // sum, seen samples
  Eigen::Matrix4Xf round_vertex = Eigen::Matrix4Xf::Zero(4, static_cast<Eigen::Index>(snapshot.shape->vertices.size()));
  for (std::size_t t = 0; t < triangles; ++t) {
    auto sum = in_triangle.col(static_cast<Eigen::Index>(t));
    for (std::size_t s = snapshot.maps->first_sample(t); s < snapshot.maps->first_sample(t + 1); ++s)
      if (snapshot.known[s]) sum += snapshot.colour.col(static_cast<Eigen::Index>(s)).homogeneous();
    for (const std::uint32_t v : snapshot.shape->triangles[t]) round_vertex.col(v) += sum;
  }
  std::vector<std::uint8_t> seen(snapshot.shape->vertices.size());
  for (std::size_t v = 0; v < seen.size(); ++v) seen[v] = round_vertex(3, static_cast<Eigen::Index>(v)) > 0;
  const std::vector<std::uint32_t> source = nearest_seen(*snapshot.shape, seen);
  for (std::size_t t = 0; t < triangles; ++t) {
    const std::uint32_t nearest = source[snapshot.shape->triangles[t][0]];
    if (nearest == kNoVertex) return;  // no image shows anything
    const Eigen::Vector4f sum = in_triangle(3, static_cast<Eigen::Index>(t)) > 0
                                    ? in_triangle.col(static_cast<Eigen::Index>(t))
                                    : round_vertex.col(nearest);
    for (std::size_t s = snapshot.maps->first_sample(t); s < snapshot.maps->first_sample(t + 1); ++s)
      if (!snapshot.known[s]) snapshot.colour.col(static_cast<Eigen::Index>(s)) = sum.head<3>() / sum[3];
  }
}

}  // namespace

ConstantColour::ConstantColour(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const MapLayout> maps)
    : mesh_(std::move(mesh)),
      maps_(std::move(maps)),
      sum_(Eigen::Matrix3Xf::Zero(3, static_cast<Eigen::Index>(maps_->total_samples()))),
      count_(maps_->total_samples(), 0) {}

void ConstantColour::add(std::size_t triangle, std::span<const std::uint8_t> visible,
                         const Eigen::Ref<const Eigen::Matrix3Xf>& encoded) {
  const auto first = static_cast<Eigen::Index>(maps_->first_sample(triangle));
  if (!std::memchr(visible.data(), 0, static_cast<std::size_t>(encoded.cols()))) {  // most triangles show whole
    sum_.middleCols(first, encoded.cols()) += encoded;
    for (Eigen::Index s = 0; s < encoded.cols(); ++s) ++count_[first + s];
    return;
  }
  for (Eigen::Index s = 0; s < encoded.cols(); ++s)
    if (visible[s]) {
      sum_.col(first + s) += encoded.col(s);
      ++count_[first + s];
    }
}

void ConstantColour::add(const SurfaceImage& image) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, maps_->triangles(), 128), [&](const auto& range) {
    Eigen::Matrix3Xf encoded;
    for (std::size_t t = range.begin(); t < range.end(); ++t) {
      if (image.view.visible_in_triangle[t] == 0) continue;
      encoded.resize(3, lattice_samples(maps_->resolution(t)));
      resample(image, t, encoded);
      add(t, std::span(image.view.visible).subspan(maps_->first_sample(t)), encoded);
    }
  });
}

void ConstantColour::add(const PatchShape& patch, const PatchColumn& column) {
  for (std::size_t i = 0; i < patch.triangles.size(); ++i) {
    const std::uint32_t t = patch.triangles[i], from = patch.first_sample[i];
    add(t, std::span(column.visible).subspan(from),
        Eigen::Map<const Eigen::Matrix3Xf>(column.values.data() + 3 * std::size_t{from}, 3,
                                           lattice_samples(maps_->resolution(t))));
  }
}

void ConstantColour::remove(const PatchShape& patch, const PatchColumn& column) {
  for (std::size_t i = 0; i < patch.triangles.size(); ++i) {
    const std::uint32_t t = patch.triangles[i];
    const auto first = static_cast<Eigen::Index>(maps_->first_sample(t));
    for (Eigen::Index s = 0; s < lattice_samples(maps_->resolution(t)); ++s) {
      const Eigen::Index from = patch.first_sample[i] + s;
      if (!column.visible[static_cast<std::size_t>(from)] || count_[first + s] == 0) continue;
      sum_.col(first + s) -= column.values.segment<3>(3 * from);
      --count_[first + s];
    }
  }
}

std::vector<float> ConstantColour::log_ratios(const SurfaceImage& image) const {
  const SurfaceView& view = image.view;
  std::vector<float> ratios(view.cosine.size(), std::numeric_limits<float>::quiet_NaN());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ratios.size(), 128), [&](const auto& range) {
    Eigen::Matrix3Xf encoded;
    for (std::size_t t = range.begin(); t < range.end(); ++t) {
      if (view.visible_in_triangle[t] == 0) continue;
      encoded.resize(3, lattice_samples(maps_->resolution(t)));
      resample(image, t, encoded);
      float seen = 0, expected = 0;
      int values = 0;
      const auto first = static_cast<Eigen::Index>(maps_->first_sample(t));
      for (Eigen::Index s = 0; s < encoded.cols(); ++s)
        if (view.visible[first + s] && count_[first + s] > 0) {
          seen += encoded.col(s).sum();
          expected += sum_.col(first + s).sum() / static_cast<float>(count_[first + s]);
          values += 3;
        }
      if (values > 0) ratios[t] = log_ratio(seen / static_cast<float>(values), expected / static_cast<float>(values));
    }
  });
  return ratios;
}

std::shared_ptr<const Appearance> ConstantColour::snapshot(ExposureField exposure) const {
  auto snapshot = std::make_shared<ConstantColourSnapshot>();
  snapshot->shape = mesh_;
  snapshot->maps = maps_;
  snapshot->exposure = std::move(exposure);
  snapshot->colour = sum_;
  snapshot->known.resize(count_.size());
  for (std::size_t s = 0; s < count_.size(); ++s) {
    snapshot->known[s] = count_[s] > 0;
    snapshot->colour.col(static_cast<Eigen::Index>(s)) /= static_cast<float>(std::max(count_[s], 1u));
  }
  fill_unseen(*snapshot);
  return snapshot;
}

}  // namespace sheen
