// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "reconstructor/light_field_file/patch_shapes.h"
#include "reconstructor/numerics/packed_columns.h"
#include "reconstructor/surface/colour_planes.h"
#include "reconstructor/surface/sample_state.h"

namespace sheen {

/// Fraction of a patch's images that showed a sample, in 255ths; 0 only where none did, and no more than 255.
std::uint8_t shown_fraction(int showed_it, int images);
/// What such a fraction says of the sample. The one place where the states are told apart.
SampleState sample_state(std::uint8_t shown);

/// Surface maps of a part of the surface: the encoded colour of a sample = sum_r (its colour in term r) * h_r, with
/// coefficients h of the eye. Colours are sRGB-encoded (`srgb_encode`); the sum over a triangle's corners is decoded
/// once, at the end.
struct SurfacePatch {
  /// Rows x rank: those of `planes`, or 3 * sample + channel where these are null.
  PackedColumns<float> basis;
  std::shared_ptr<const ColourPlanes> planes;
  std::vector<std::uint8_t> shown;  ///< per sample: fraction of the images that showed it (`shown_fraction`)

  int rank() const { return static_cast<int>(basis.cols()); }
  SampleState state(int sample) const { return sample_state(shown[static_cast<std::size_t>(sample)]); }

  /// Between samples of the triangle that has this first sample. `h`: rank.
  Eigen::Vector3f colour(int first_sample, const LatticeStencil& at, const Eigen::VectorXf& h) const;
  /// At barycentric (u, v) of a triangle of the patch, whose stencil there is `at`: its maps times the mean of its
  /// corners' view coefficients, weighted barycentrically. `coefficients`: of an eye, a column per `place.columns`.
  Eigen::Vector3f colour(const TrianglePlace& place, const LatticeStencil& at, const Eigen::MatrixXf& coefficients,
                         float u, float v) const;
  /// Of all samples in one term: 3 x samples values.
  Eigen::VectorXf colours_of_term(int term) const;
  /// Of all samples, or so many, those of the triangle with this first sample, in all terms: 3 x samples values x rank.
  Eigen::MatrixXf colours() const;
  Eigen::MatrixXf colours(int first_sample, int samples) const;
  /// Over the samples that were seen: 3 x rank.
  Eigen::MatrixXf mean_seen_colours() const;
};

}  // namespace sheen
