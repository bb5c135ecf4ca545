// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/constant_colour.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/image/color.h"
#include "reconstructor/surface/lattice_resampling.h"
#include "reconstructor/surface/nearest_seen.h"

namespace sheen {
namespace {

constexpr float kMostCode = std::numeric_limits<std::uint16_t>::max();
constexpr std::uint16_t kMostImages = std::numeric_limits<std::uint16_t>::max();

/// To codes.
template <typename Values>
auto rounded(const Values& values) {
  return (values.max(0.0f).min(kMostCode) + 0.5f).template cast<int>().eval();
}

std::uint16_t to_code(float value) {
  return static_cast<std::uint16_t>(rounded(Eigen::Array<float, 1, 1>(value))[0]);
}

/// Where no image showed the surface, per triangle: the mean of its seen samples, or, where it has none, that of the
/// triangles round the seen vertex that is nearest to its first corner. 3 x triangles; 0 where no image shows anything.
Eigen::Matrix3Xf unseen_colours(const ConstantColour& means) {
  const Mesh& mesh = *means.shared_mesh();
  const auto triangles = static_cast<Eigen::Index>(mesh.triangles.size());
  Eigen::Matrix4Xf in_triangle = Eigen::Matrix4Xf::Zero(4, triangles);  // sum, seen samples
  Eigen::Matrix4Xf round_vertex = Eigen::Matrix4Xf::Zero(4, static_cast<Eigen::Index>(mesh.vertices.size()));
  for (Eigen::Index t = 0; t < triangles; ++t) {
    auto sum = in_triangle.col(t);
    for (int s = 0; s < lattice_samples(means.maps().resolution(t)); ++s)
      if (means.seen(t, s)) sum += means.colour(t, s).homogeneous();
    for (const std::uint32_t v : mesh.triangles[t]) round_vertex.col(v) += sum;
  }
  std::vector<std::uint8_t> seen(mesh.vertices.size());
  for (std::size_t v = 0; v < seen.size(); ++v) seen[v] = round_vertex(3, static_cast<Eigen::Index>(v)) > 0;
  const std::vector<std::uint32_t> source = nearest_seen(mesh, seen);
  Eigen::Matrix3Xf unseen = Eigen::Matrix3Xf::Zero(3, triangles);
  for (Eigen::Index t = 0; t < triangles; ++t) {
    const std::uint32_t nearest = source[mesh.triangles[t][0]];
    if (nearest == kNoVertex) break;
    const Eigen::Vector4f sum = in_triangle(3, t) > 0 ? in_triangle.col(t) : round_vertex.col(nearest);
    unseen.col(t) = sum.head<3>() / sum[3];
  }
  return unseen;
}

struct ConstantColourAppearance : public Appearance {
  std::shared_ptr<const ConstantColour> means;
  Eigen::Matrix3Xf unseen;
  ExposureField exposure;

  const Mesh& mesh() const override { return *means->shared_mesh(); }
  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override;
};

class ConstantColourShader : public ViewShader {
 public:
  ConstantColourShader(const ConstantColourAppearance& model, float exposure) : model_(model), exposure_(exposure) {}

  SurfaceSample shade(std::uint32_t triangle, float u, float v) const override {
    const ConstantColour& means = *model_.means;
    const LatticeStencil stencil = lattice_stencil(means.maps().resolution(triangle), u, v);
    Eigen::Vector3f encoded = Eigen::Vector3f::Zero();
    bool measured = false;
    for (int k = 0; k < 3; ++k) {
      const int s = stencil.index[k];
      const bool seen = means.seen(triangle, s);
      encoded += stencil.weight[k] * (seen ? means.colour(triangle, s) : Eigen::Vector3f(model_.unseen.col(triangle)));
      measured |= stencil.weight[k] > 0.25f && seen;
    }
    const Eigen::Vector3f radiance(srgb_decode(encoded.x()), srgb_decode(encoded.y()), srgb_decode(encoded.z()));
    return {exposure_ * radiance, measured ? SampleState::kMeasured : SampleState::kUnseen};
  }
  SurfaceQuality quality(std::uint32_t) const override { return {true, 0, 1, 1}; }  // it claims nothing

 private:
  const ConstantColourAppearance& model_;
  float exposure_;
};

std::unique_ptr<ViewShader> ConstantColourAppearance::shader_for(const ViewQuery& query) const {
  return std::make_unique<ConstantColourShader>(*this, exposure.at(query.eye));
}

float log_ratio(float encoded_seen, float encoded_expected) {
  const auto usable = [](float v) { return v > 0.03f && v < 0.97f; };  // black and clipped values tell no gain
  if (!usable(encoded_seen) || !usable(encoded_expected)) return std::numeric_limits<float>::quiet_NaN();
  return std::log(srgb_decode(encoded_seen) / srgb_decode(encoded_expected));
}

}  // namespace

ConstantColour::ConstantColour(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const MapLayout> maps)
    : mesh_(std::move(mesh)), maps_(std::move(maps)), samples_(maps_->triangles()), exponent_(maps_->triangles(), 0) {}

Eigen::Vector3f ConstantColour::colour(std::size_t triangle, int sample) const {
  const auto& code = samples_[triangle][static_cast<std::size_t>(sample)].code;
  return scale(triangle) * Eigen::Vector3f(code[0], code[1], code[2]);
}

float ConstantColour::scale(std::size_t triangle) const {
  return std::ldexp(1.0f / kMostCode, exponent_[triangle]);
}

void ConstantColour::make_room(std::size_t triangle, float brightest) {
  int halvings = 0;
  while (brightest > kMostCode * std::ldexp(scale(triangle), halvings) && exponent_[triangle] + halvings < 127)
    ++halvings;
  if (halvings == 0) return;
  exponent_[triangle] = static_cast<std::int8_t>(exponent_[triangle] + halvings);
  for (Sample& sample : samples_[triangle])
    for (std::uint16_t& code : sample.code) code = static_cast<std::uint16_t>(halvings < 16 ? code >> halvings : 0);
}

/// `encoded` is 0 where the sample is not visible.
void ConstantColour::add(std::size_t triangle, std::span<const std::uint8_t> visible,
                         const Eigen::Map<const Eigen::Matrix3Xf>& encoded) {
  if (samples_[triangle].empty()) samples_[triangle].resize(static_cast<std::size_t>(encoded.cols()));
  make_room(triangle, encoded.maxCoeff());
  const float codes_per_unit = 1 / scale(triangle);
  Sample* sample = samples_[triangle].data();
  for (Eigen::Index s = 0; s < encoded.cols(); ++s, ++sample) {
    if (!visible[s]) continue;
    if (sample->images < kMostImages) ++sample->images;
    const float share = 1 / static_cast<float>(sample->images);
    auto& code = sample->code;
    const float* const value = encoded.col(s).data();
    const Eigen::Array4f before(code[0], code[1], code[2], 0), now(value[0], value[1], value[2], 0);
    const Eigen::Array4i after = rounded(before + share * (codes_per_unit * now - before));
    for (int c = 0; c < 3; ++c) code[c] = static_cast<std::uint16_t>(after[c]);
  }
}

void ConstantColour::add(const SurfaceImage& image) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, maps_->triangles(), 128), [&](const auto& range) {
    Eigen::Matrix3Xf encoded;
    for (std::size_t t = range.begin(); t < range.end(); ++t) {
      if (image.view.visible_in_triangle[t] == 0) continue;
      encoded.setZero(3, lattice_samples(maps_->resolution(t)));
      resample(image, t, encoded);
      add(t, std::span(image.view.visible).subspan(maps_->first_sample(t)), {encoded.data(), 3, encoded.cols()});
    }
  });
}

void ConstantColour::add(const PatchShape& patch, const PatchColumn& column) {
  std::size_t from = 0;
  for (const std::uint32_t t : patch.triangles) {
    const int count = lattice_samples(maps_->resolution(t));
    add(t, std::span(column.visible).subspan(from),
        Eigen::Map<const Eigen::Matrix3Xf>(column.values.data() + 3 * from, 3, count));
    from += static_cast<std::size_t>(count);
  }
}

void ConstantColour::remove(const PatchShape& patch, const PatchColumn& column) {
  Eigen::Index from = -1;
  for (const std::uint32_t t : patch.triangles) {
    const float step = scale(t);
    for (Sample& sample : samples_[t]) {
      ++from;
      if (!column.visible[static_cast<std::size_t>(from)] || sample.images == 0) continue;
      const auto left = static_cast<float>(--sample.images);
      for (int c = 0; c < 3; ++c) {
        const auto code = static_cast<float>(sample.code[c]);
        sample.code[c] =
            left > 0 ? to_code(code + (code - column.values[3 * from + c] / step) / left) : std::uint16_t{0};
      }
    }
  }
}

/// A sample was seen in as many images as those round it were.
std::vector<ConstantColour::Sample> ConstantColour::carried(std::span<const Sample> from, int side, int to_side) {
  const LatticeResampling resampling(side, to_side);
  Eigen::Matrix3Xf codes(3, static_cast<Eigen::Index>(from.size()));
  for (std::size_t s = 0; s < from.size(); ++s)
    for (int c = 0; c < 3; ++c) codes(c, static_cast<Eigen::Index>(s)) = from[s].code[c];
  const Eigen::Matrix3Xf carried = resampling.of(codes);
  std::vector<Sample> samples(static_cast<std::size_t>(carried.cols()));
  for (Eigen::Index s = 0; s < carried.cols(); ++s) {
    const LatticeStencil& round = resampling.round(static_cast<int>(s));
    Sample& sample = samples[static_cast<std::size_t>(s)];
    sample.images = kMostImages;
    for (int k = 0; k < 3; ++k)
      if (round.weight[k] > 0)
        sample.images = std::min(sample.images, from[static_cast<std::size_t>(round.index[k])].images);
    if (sample.images == 0) continue;
    for (int c = 0; c < 3; ++c) sample.code[c] = to_code(carried(c, s));
  }
  return samples;
}

void ConstantColour::use(std::shared_ptr<const MapLayout> maps) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, maps->triangles(), 128), [&](const auto& range) {
    for (std::size_t t = range.begin(); t < range.end(); ++t)
      if (const int side = maps_->resolution(t), to_side = maps->resolution(t); !samples_[t].empty() && side != to_side)
        samples_[t] = carried(samples_[t], side, to_side);
  });
  maps_ = std::move(maps);
}

std::vector<float> ConstantColour::log_ratios(const SurfaceImage& image) const {
  const SurfaceView& view = image.view;
  std::vector<float> ratios(view.cosine.size(), std::numeric_limits<float>::quiet_NaN());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ratios.size(), 128), [&](const auto& range) {
    Eigen::Matrix3Xf encoded;
    for (std::size_t t = range.begin(); t < range.end(); ++t) {
      if (view.visible_in_triangle[t] == 0 || samples_[t].empty()) continue;
      encoded.resize(3, lattice_samples(maps_->resolution(t)));
      resample(image, t, encoded);
      float seen = 0, expected = 0;
      int values = 0;
      const std::size_t first = maps_->first_sample(t);
      const float step = scale(t);
      for (Eigen::Index s = 0; s < encoded.cols(); ++s) {
        const Sample& sample = samples_[t][static_cast<std::size_t>(s)];
        if (!view.visible[first + s] || sample.images == 0) continue;
        seen += encoded.col(s).sum();
        expected += step * static_cast<float>(sample.code[0] + sample.code[1] + sample.code[2]);
        values += 3;
      }
      if (values > 0) ratios[t] = log_ratio(seen / static_cast<float>(values), expected / static_cast<float>(values));
    }
  });
  return ratios;
}

std::shared_ptr<const Appearance> appearance_of(std::shared_ptr<const ConstantColour> means, ExposureField exposure) {
  auto appearance = std::make_shared<ConstantColourAppearance>();
  appearance->unseen = unseen_colours(*means);
  appearance->means = std::move(means);
  appearance->exposure = std::move(exposure);
  return appearance;
}

}  // namespace sheen
