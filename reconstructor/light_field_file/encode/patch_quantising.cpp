// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/patch_quantising.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "reconstructor/light_field_file/encode/band_rounding.h"
#include "reconstructor/light_field_file/lattice_spectrum.h"
#include "reconstructor/surface/colour_planes.h"

namespace sheen {
namespace {

constexpr float kCoefficientThreshold = 0.52f;

// Terms of which next to nothing is left keep their coefficients.
constexpr double kRidge = 0.02;

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
  frequencies.join_levels();
  std::vector<std::vector<std::int32_t>> bands;
  bands.reserve(3 * frequencies.tiles.size());
  BandRounding rounding(bit_price);
  for (const Eigen::MatrixX3f& tile : frequencies.tiles)
    for (int c = 0; c < 3; ++c) bands.push_back(rounding.rounded(tile.col(c), c));
  QuantisedMap map;
  map.assign(bands);
  return map;
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
    const float size = size_of_scale(term.scale) / unit;
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

}  // namespace sheen
