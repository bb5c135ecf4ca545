// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/patch_spectrum.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "reconstructor/coding/powers.h"
#include "reconstructor/models/surface_light_field/compact/band_rounding.h"
#include "reconstructor/models/surface_light_field/compact/lattice_spectrum.h"
#include "reconstructor/surface/colour_planes.h"

namespace sheen {
namespace {

constexpr float kCoefficientThreshold = 0.52f, kCoefficientShift = 0.02f;

/// Step of a patch's coefficients. An error of a coefficient is in all rows of one image, one of a map in one row of
/// all images: they cost the same where the squares of the steps are as these numbers (reverse water-filling). Kriging
/// takes the mean of some images, and with it a part of the errors of their coefficients.
float coefficient_step(float step, Eigen::Index images, Eigen::Index rows) {
  constexpr float kAveraged = 1.4f;
  return kAveraged * step * std::sqrt(static_cast<float>(images) / static_cast<float>(rows));
}

// Terms of which next to nothing is left keep their coefficients.
constexpr double kRidge = 0.02;

/// The levels of a map's tiles, their first frequencies, differ little: joined two and two again and again, by the
/// unbalanced Haar transform, most of them is in one number. levels, weights: a row per tile; `weights` are the roots
/// of the tiles' sizes. The first row is that number, times the root of all their sizes.
void join_levels(Eigen::Ref<Eigen::MatrixX3f> levels, Eigen::VectorXf weights, bool forward) {
  struct Join {
    Eigen::Index into, from;
    float weight_into, weight_from;
  };
  std::vector<Join> joins;
  for (Eigen::Index step = 1; step < levels.rows(); step *= 2)
    for (Eigen::Index i = 0; i + step < levels.rows(); i += 2 * step) {
      const float whole = std::sqrt(weights[i] * weights[i] + weights[i + step] * weights[i + step]);
      joins.push_back({i, i + step, weights[i] / whole, weights[i + step] / whole});
      weights[i] = whole;
    }
  if (!forward) std::reverse(joins.begin(), joins.end());
  for (const Join& join : joins) {
    const Eigen::RowVector3f a = levels.row(join.into), b = levels.row(join.from);
    const float wa = join.weight_into, wb = join.weight_from;
    levels.row(join.into) = wa * a + wb * b;  // its own inverse
    levels.row(join.from) = wb * a - wa * b;
  }
}

/// Frequencies of a map's tiles, a block of rows after the other: their number of rows each, luma and two differences.
struct MapFrequencies {
  std::vector<Eigen::MatrixX3f> tiles;
  std::vector<std::size_t> sizes;  ///< samples of each tile

  void join(bool forward) {
    Eigen::MatrixX3f levels(static_cast<Eigen::Index>(tiles.size()), 3);
    Eigen::VectorXf weights(levels.rows());
    for (Eigen::Index t = 0; t < levels.rows(); ++t) {
      levels.row(t) = tiles[static_cast<std::size_t>(t)].row(0);
      weights[t] = std::sqrt(static_cast<float>(sizes[static_cast<std::size_t>(t)]));
    }
    join_levels(levels, weights, forward);
    for (Eigen::Index t = 0; t < levels.rows(); ++t) tiles[static_cast<std::size_t>(t)].row(0) = levels.row(t);
  }
};

/// values: rows 3 * sample + channel.
QuantisedMap quantise_map(const Eigen::Ref<const Eigen::VectorXf>& values, const std::vector<int>& resolutions,
                          float step, float bit_price) {
  const Eigen::Matrix3f& colours = opponent_colours();
  MapFrequencies frequencies;
  const float* first = values.data();
  for (const int resolution : resolutions) {
    const Eigen::Map<const Eigen::Matrix3Xf> rgb(first, 3, lattice_samples(resolution));
    for (const LatticeSpectrum::Tile& tile : lattice_spectrum(resolution).tiles) {
      Eigen::MatrixX3f samples(static_cast<Eigen::Index>(tile.samples.size()), 3);
      for (std::size_t s = 0; s < tile.samples.size(); ++s)
        samples.row(static_cast<Eigen::Index>(s)) = (colours * rgb.col(tile.samples[s])).transpose() / step;
      frequencies.tiles.emplace_back(tile.vectors->transpose() * samples);
      frequencies.sizes.push_back(tile.samples.size());
    }
    first += rgb.size();
  }
  frequencies.join(true);
  std::vector<std::vector<std::int32_t>> bands;
  bands.reserve(3 * frequencies.tiles.size());
  BandRounding rounding(bit_price);
  for (const Eigen::MatrixX3f& tile : frequencies.tiles)
    for (int c = 0; c < 3; ++c) bands.push_back(rounding.rounded(tile.col(c), c));
  QuantisedMap map;
  map.assign(bands);
  return map;
}

void dequantise_map(const QuantisedMap& map, const std::vector<int>& resolutions, float step,
                    Eigen::Ref<Eigen::VectorXf> values) {
  const Eigen::Matrix3f to_rgb = opponent_colours().transpose();
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
  frequencies.join(false);
  float* first = values.data();
  std::size_t next = 0;
  for (const int resolution : resolutions) {
    Eigen::Map<Eigen::Matrix3Xf> rgb(first, 3, lattice_samples(resolution));
    for (const LatticeSpectrum::Tile& tile : lattice_spectrum(resolution).tiles) {
      const Eigen::MatrixX3f& here = frequencies.tiles[next++];
      const Eigen::MatrixX3f samples = tile.vectors->leftCols(here.rows()) * here;
      for (std::size_t s = 0; s < tile.samples.size(); ++s)
        rgb.col(tile.samples[s]) = to_rgb * samples.row(static_cast<Eigen::Index>(s)).transpose();
    }
    first += rgb.size();
  }
}

/// Haar coefficients over a patch's images, as they are stored.
std::vector<std::int32_t> quantise_coefficients(Eigen::VectorXf values, const ViewHaar::Plan& plan, float step) {
  ViewHaar::forward(plan, values);
  std::vector<std::int32_t> quantised;
  for (const float value : values) {
    constexpr float kMost = 1 << 22;
    const float size = std::min(std::floor(std::abs(value) / step + 1 - kCoefficientThreshold), kMost);
    quantised.push_back(static_cast<std::int32_t>(std::copysign(size, value)));
  }
  return quantised;
}

Eigen::VectorXf dequantise_coefficients(const std::vector<std::int32_t>& coefficients, const ViewHaar::Plan& plan,
                                        float step) {
  Eigen::VectorXf values(static_cast<Eigen::Index>(coefficients.size()));
  for (std::size_t j = 0; j < coefficients.size(); ++j) {
    const auto value = static_cast<float>(coefficients[j]);
    values[static_cast<Eigen::Index>(j)] =
        coefficients[j] == 0 ? 0.0f : step * (value + std::copysign(kCoefficientShift, value));
  }
  ViewHaar::inverse(plan, values);
  return values;
}

/// How large a map is that a term of this scale has, RMS in grey levels.
float size_of(std::int32_t scale) {
  return static_cast<float>(power_of_two(6 * std::clamp(scale, -40, 40)));
}

/// The coefficients with which rounded columns come as near as they can (least squares) to what the exact columns, as
/// many, show with theirs.
Eigen::MatrixXf refitted(const Eigen::MatrixXf& rounded, const Eigen::MatrixXf& exact,
                         const Eigen::Ref<const Eigen::MatrixXf>& coefficients) {
  Eigen::MatrixXd gram = (rounded.transpose() * rounded).cast<double>(),
                  cross = (rounded.transpose() * exact).cast<double>();
  const Eigen::VectorXd ridge = kRidge * gram.diagonal();
  gram.diagonal() += ridge;
  cross.diagonal() += ridge;
  return (gram.ldlt().solve(cross) * coefficients.cast<double>()).cast<float>();
}

}  // namespace

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

QuantisedPatch quantise(const Patch& patch, const std::vector<int>& resolutions, const ViewHaar::Plan& plan, float step,
                        const Rounding& rounding) {
  QuantisedPatch quantised_patch{.known = patch.mean.size() > 0};
  if (!quantised_patch.known) return quantised_patch;
  quantised_patch.mean = quantise_map(patch.mean, resolutions, step, rounding.bit_price);
  // A basis of unit RMS makes the coefficients grey levels.
  const float unit = 1 / std::sqrt(static_cast<float>(patch.basis.rows()));
  std::vector<QuantisedTerm>& terms = quantised_patch.terms;
  Eigen::MatrixXf rounded(patch.basis.rows(), patch.basis.cols());
  for (Eigen::Index k = 0; k < patch.basis.cols() && patch.displayed[k] >= rounding.least_term * step; ++k) {
    QuantisedTerm term{.scale = static_cast<std::int32_t>(std::lround(2 * std::log2(patch.displayed[k])))};
    const float size = size_of(term.scale) / unit;
    term.map = quantise_map(patch.basis.column(k) * size, resolutions, step, rounding.bit_price);
    if (term.map.is_zero()) break;
    dequantise_map(term.map, resolutions, step, rounded.col(k));
    rounded.col(k) /= size;
    terms.push_back(std::move(term));
  }
  if (terms.empty()) return quantised_patch;
  const auto count = static_cast<Eigen::Index>(terms.size());
  const Eigen::MatrixXf coefficients = refitted(
      rounded.leftCols(count), patch.basis.unpacked(0, patch.basis.rows(), count), patch.coefficients.topRows(count));
  for (std::size_t k = 0; k < terms.size(); ++k) {
    terms[k].coefficients = quantise_coefficients(unit * coefficients.row(static_cast<Eigen::Index>(k)).transpose(),
                                                  plan, coefficient_step(step, plan.size, patch.basis.rows()));
    if (std::all_of(terms[k].coefficients.begin(), terms[k].coefficients.end(), [](std::int32_t v) { return v == 0; }))
      terms.resize(k);
  }
  return quantised_patch;
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
        size_of(term.scale);
  }
  patch.basis = std::move(basis);
  return patch;
}

}  // namespace sheen
