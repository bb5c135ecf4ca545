// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/patch_spectrum.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "reconstructor/coding/powers.h"
#include "reconstructor/light_field_file/lattice_spectrum.h"
#include "reconstructor/surface/colour_planes.h"

// Sums are written out, a product and a sum after the other: what a file holds is the same to the last bit on every
// machine (this room is compiled without contraction).

namespace sheen {
namespace {

/// Two tiles whose levels are joined: of so many samples together.
struct Join {
  std::size_t into, from;
  float weight_into, weight_from;
};

/// From the tiles up, two and two.
std::vector<Join> joins_of(const std::vector<std::size_t>& sizes) {
  std::vector<float> weights;  // the roots of the tiles' sizes
  for (const std::size_t size : sizes) weights.push_back(std::sqrt(static_cast<float>(size)));
  std::vector<Join> joins;
  for (std::size_t step = 1; step < sizes.size(); step *= 2)
    for (std::size_t i = 0; i + step < sizes.size(); i += 2 * step) {
      const float whole = std::sqrt(weights[i] * weights[i] + weights[i + step] * weights[i + step]);
      joins.push_back({i, i + step, weights[i] / whole, weights[i + step] / whole});
      weights[i] = whole;
    }
  return joins;
}

/// Its own inverse.
void turn(const Join& join, std::vector<Eigen::MatrixX3f>& tiles) {
  for (Eigen::Index c = 0; c < 3; ++c) {
    float &a = tiles[join.into](0, c), &b = tiles[join.from](0, c);
    const float sum = join.weight_into * a + join.weight_from * b;
    b = join.weight_from * a - join.weight_into * b;
    a = sum;
  }
}

/// samples += frequencies * weights, frequency after frequency. frequencies: samples x frequencies.
void add_frequencies(const Eigen::MatrixXf& frequencies, const Eigen::MatrixX3f& weights, Eigen::MatrixX3f& samples) {
  for (Eigen::Index c = 0; c < 3; ++c) {
    float* const out = samples.col(c).data();
    for (Eigen::Index f = 0; f < weights.rows(); ++f) {
      const float weight = weights(f, c);
      if (weight == 0) continue;
      const float* const from = frequencies.col(f).data();
      for (Eigen::Index s = 0; s < samples.rows(); ++s) out[s] += weight * from[s];
    }
  }
}

Eigen::VectorXf dequantise_coefficients(const std::vector<std::int32_t>& coefficients, const ViewHaar::Plan& plan,
                                        float step) {
  Eigen::VectorXf values(static_cast<Eigen::Index>(coefficients.size()));
  for (std::size_t j = 0; j < coefficients.size(); ++j) {
    values[static_cast<Eigen::Index>(j)] = step * coefficient_value(coefficients[j]);
  }
  ViewHaar::inverse(plan, values);
  return values;
}

/// A size a little larger than that of the whole number.
float shifted(std::int32_t value, float shift) {
  return value == 0 ? 0.0f : static_cast<float>(value) + (value < 0 ? -shift : shift);
}

}  // namespace

float rounded_value(std::int32_t value) {
  return shifted(value, 0.08f);
}

float coefficient_value(std::int32_t value) {
  return shifted(value, 0.02f);
}

/// An error of a coefficient is in all rows of one image, one of a map in one row of all images: they cost the same
/// where the squares of the steps are as these numbers (reverse water-filling). Kriging takes the mean of some images,
/// and with it a part of the errors of their coefficients.
float coefficient_step(float step, Eigen::Index images, Eigen::Index rows) {
  constexpr float kAveraged = 1.4f;
  return kAveraged * step * std::sqrt(static_cast<float>(images) / static_cast<float>(rows));
}

float size_of_scale(std::int32_t scale) {
  return static_cast<float>(power_of_two(6 * std::clamp(scale, -40, 40)));
}

void MapFrequencies::join_levels() {
  for (const Join& join : joins_of(sizes)) turn(join, tiles);
}

void MapFrequencies::part_levels() {
  std::vector<Join> joins = joins_of(sizes);
  std::reverse(joins.begin(), joins.end());
  for (const Join& join : joins) turn(join, tiles);
}

void QuantisedMap::assign(std::span<const std::vector<std::int32_t>> bands) {
  std::size_t count = 0;
  for (const auto& band : bands) count += band.size();
  values_.clear();
  values_.reserve(count);
  ends_.clear();
  ends_.reserve(bands.size());
  for (const auto& band : bands) {
    values_.insert(values_.end(), band.begin(), band.end());
    ends_.push_back(static_cast<std::uint32_t>(values_.size()));
  }
}

void dequantise_map(const QuantisedMap& map, const std::vector<int>& resolutions, float step,
                    Eigen::Ref<Eigen::VectorXf> values) {
  MapFrequencies frequencies;
  std::size_t first_band = 0;
  for (const int resolution : resolutions)
    for (const LatticeSpectrum::Tile& tile : lattice_spectrum(resolution).tiles) {
      const QuantisedMap::Band bands[3] = {map.band(first_band), map.band(first_band + 1), map.band(first_band + 2)};
      std::size_t used = 1;
      for (const QuantisedMap::Band& band : bands) used = std::max(used, band.size());
      Eigen::MatrixX3f& here =
          frequencies.tiles.emplace_back(Eigen::MatrixX3f::Zero(static_cast<Eigen::Index>(used), 3));
      for (int c = 0; c < 3; ++c)
        for (std::size_t f = 0; f < bands[c].size(); ++f)
          here(static_cast<Eigen::Index>(f), c) = step * rounded_value(bands[c][f]);
      frequencies.sizes.push_back(tile.samples.size());
      first_band += 3;
    }
  frequencies.part_levels();
  const Eigen::Matrix3f& opponent = opponent_colours();
  float* rgb = values.data();
  std::size_t next = 0;
  for (const int resolution : resolutions) {
    for (const LatticeSpectrum::Tile& tile : lattice_spectrum(resolution).tiles) {
      Eigen::MatrixX3f samples = Eigen::MatrixX3f::Zero(static_cast<Eigen::Index>(tile.samples.size()), 3);
      add_frequencies(*tile.vectors, frequencies.tiles[next++], samples);
      for (std::size_t s = 0; s < tile.samples.size(); ++s) {
        const auto row = static_cast<Eigen::Index>(s);
        for (int c = 0; c < 3; ++c)
          rgb[3 * tile.samples[s] + c] =
              opponent(0, c) * samples(row, 0) + opponent(1, c) * samples(row, 1) + opponent(2, c) * samples(row, 2);
      }
    }
    rgb += 3 * lattice_samples(resolution);
  }
}

Patch dequantise(const QuantisedPatch& quantised_patch, const std::vector<int>& resolutions, const ViewHaar::Plan& plan,
                 float step) {
  Patch patch;
  if (!quantised_patch.known) return patch;
  const auto terms = static_cast<Eigen::Index>(quantised_patch.terms.size());
  Eigen::Index rows = 0;
  for (const int resolution : resolutions) rows += 3 * lattice_samples(resolution);
  patch.mean.resize(rows);
  dequantise_map(quantised_patch.mean, resolutions, step, patch.mean);
  Eigen::MatrixXf basis(rows, terms);
  patch.coefficients.resize(terms, plan.size);
  for (Eigen::Index k = 0; k < terms; ++k) {
    const QuantisedTerm& term = quantised_patch.terms[static_cast<std::size_t>(k)];
    dequantise_map(term.map, resolutions, step, basis.col(k));
    patch.coefficients.row(k) =
        dequantise_coefficients(term.coefficients, plan, coefficient_step(step, plan.size, rows)).transpose() /
        size_of_scale(term.scale);
  }
  patch.basis = std::move(basis);
  return patch;
}

}  // namespace sheen
