// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/surface_patch.h"

#include <algorithm>
#include <cmath>

namespace sheen {

std::uint8_t shown_fraction(int showed_it, int images) {
  if (showed_it <= 0) return 0;
  return static_cast<std::uint8_t>(std::clamp(std::lround(255.0 * showed_it / std::max(images, 1)), 1L, 255L));
}

SampleState sample_state(std::uint8_t shown) {
  constexpr int kHalf = 128;
  if (shown == 0) return SampleState::kUnseen;
  return shown < kHalf ? SampleState::kImputed : SampleState::kMeasured;
}

/// A term of three samples. Never inlined: how sums are rounded would depend on where the term comes from.
[[gnu::noinline]] static void add_term(const Eigen::Matrix3f& colours, float coefficient, Eigen::Matrix3f& sums) {
  sums += coefficient * colours;
}

Eigen::Vector3f SurfacePatch::colour(int first_sample, const LatticeStencil& at, const Eigen::VectorXf& h) const {
  Eigen::Matrix3f sums = Eigen::Matrix3f::Zero(), term;  // a column for each of the samples
  if (planes) {
    const ColourPlanes::Triangle& triangle = planes->triangle_at(first_sample);
    ColourPlanes::SampleRows rows[3];
    for (int k = 0; k < 3; ++k) rows[k] = planes->rows_of_sample(triangle, at.index[k]);
    basis.visit(h.size(), [&](Eigen::Index r, const auto& value) {
      for (int k = 0; k < 3; ++k) term.col(k) = ColourPlanes::colour(rows[k], value);
      add_term(term, h[r], sums);
    });
  } else {
    basis.visit(h.size(), [&](Eigen::Index r, const auto& value) {
      for (int k = 0; k < 3; ++k) {
        const int row = 3 * (first_sample + at.index[k]);
        term.col(k) << value(row), value(row + 1), value(row + 2);
      }
      add_term(term, h[r], sums);
    });
  }
  return sums * Eigen::Map<const Eigen::Vector3f>(at.weight);
}

Eigen::Vector3f SurfacePatch::colour(const TrianglePlace& place, const LatticeStencil& at,
                                     const Eigen::MatrixXf& coefficients, float u, float v) const {
  const auto corner = [&](std::size_t c) { return coefficients.col(place.columns[c]).head(rank()); };
  return colour(static_cast<int>(place.first_sample), at, (1 - u - v) * corner(0) + u * corner(1) + v * corner(2));
}

Eigen::VectorXf SurfacePatch::colours_of_term(int term) const {
  return planes ? planes->colours_of(basis.column(term)) : basis.column(term);
}

Eigen::MatrixXf SurfacePatch::colours() const {
  if (!planes) return basis.unpacked();
  Eigen::MatrixXf colours(3 * planes->samples(), basis.cols());
  for (int term = 0; term < rank(); ++term) colours.col(term) = colours_of_term(term);
  return colours;
}

Eigen::MatrixXf SurfacePatch::colours(int first_sample, int samples) const {
  if (!planes) return basis.unpacked(3 * first_sample, 3 * samples, rank());
  Eigen::MatrixXf colours(3 * samples, basis.cols());
  const ColourPlanes::Triangle& triangle = planes->triangle_at(first_sample);
  basis.visit(basis.cols(), [&](Eigen::Index r, const auto& value) {
    for (int sample = 0; sample < samples; ++sample)
      colours.col(r).segment<3>(3 * sample) = ColourPlanes::colour(planes->rows_of_sample(triangle, sample), value);
  });
  return colours;
}

Eigen::MatrixXf SurfacePatch::mean_seen_colours() const {
  if (planes) return planes->mean_colours(basis.unpacked(), planes->guessed_places(shown));
  const Eigen::MatrixXf rows = basis.unpacked();
  Eigen::MatrixXf mean = Eigen::MatrixXf::Zero(3, rank());
  int seen = 0;
  for (std::size_t s = 0; s < shown.size(); ++s) {
    if (shown[s] == 0) continue;
    mean += rows.middleRows<3>(static_cast<Eigen::Index>(3 * s));
    ++seen;
  }
  return mean / static_cast<float>(std::max(seen, 1));
}

}  // namespace sheen
