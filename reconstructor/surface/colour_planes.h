// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "reconstructor/numerics/row_planes.h"
#include "reconstructor/surface/map_layout.h"

namespace sheen {

/// Rows: luma, and two colour differences (chroma), of RGB. Orthonormal: squares add up to the same.
const Eigen::Matrix3f& opponent_colours();

/// Side of each of a patch's surface maps, a triangle after the other.
using MapSides = std::vector<std::uint8_t>;

/// The colours of a patch's samples as rows of a factor. Luma stands at every sample; chroma has in each triangle a
/// lattice of its own, often a coarser one, and is interpolated in between. Rows are luma of all samples, then the
/// first colour difference of all chroma samples, then the second one. A *place* is a sample or, behind these, a chroma
/// sample: images show it or do not.
class ColourPlanes {
 public:
  using ColumnRef = Eigen::Ref<const Eigen::VectorXf>;

  /// `chroma_sides`: none larger than its triangle's side.
  ColourPlanes(const MapSides& sides, const MapSides& chroma_sides);

  int samples() const { return samples_; }
  int chroma_samples() const { return chroma_samples_; }
  int rows() const { return samples_ + 2 * chroma_samples_; }
  RowPlanes row_planes() const { return {samples_, chroma_samples_, chroma_samples_}; }
  MapSides sides() const;
  MapSides chroma_sides() const;
  std::size_t bytes() const { return sizeof(*this) + sizeof(Triangle) * triangles_.capacity(); }

  /// From RGB of each sample, 3 x samples values. Where those round a chroma sample are not all visible, chroma goes on
  /// evenly from those that are. `visible`: per sample.
  Eigen::VectorXf rows_of(const ColumnRef& colours, std::span<const std::uint8_t> visible) const;
  /// The colours of all samples, or those of the triangle with this first sample: 3 x samples values.
  Eigen::VectorXf colours_of(const ColumnRef& rows) const;
  Eigen::VectorXf colours_of(const ColumnRef& rows, int first_sample) const;

  /// For each place whether it is known: a chroma sample is when the samples round it are. `samples`: per sample, 0
  /// where it is not.
  std::vector<std::uint8_t> known_places(std::span<const std::uint8_t> samples) const;
  /// The same, but a chroma sample counts when one of the samples that are interpolated from it is known.
  std::vector<std::uint8_t> guessed_places(std::span<const std::uint8_t> samples) const;
  std::vector<std::uint8_t> known_rows(std::vector<std::uint8_t> known_places) const;
  /// Of columns in these rows, the mean colour over the places that are known: 3 x columns.
  Eigen::MatrixXf mean_colours(const Eigen::Ref<const Eigen::MatrixXf>& columns,
                               std::span<const std::uint8_t> known_places) const;

  /// Of columns in these rows, chroma as it is, without its weight: 2 x chroma samples rows.
  Eigen::MatrixXf chroma_of(const Eigen::Ref<const Eigen::MatrixXf>& columns) const;

  /// Sides of chroma with which no triangle misses more than so much of its chroma, RMS over what is visible of it and
  /// has only visible samples round it: the ones that it has, or luma's. `visible`: per sample.
  MapSides sides_for_chroma_of(const ColumnRef& colours, std::span<const std::uint8_t> visible,
                               float most_missed) const;

  struct Triangle {
    std::uint8_t side, chroma_side;
    int first_sample, first_chroma;
    float chroma_weight;  ///< of chroma in its rows: a chroma sample stands for several samples

    bool chroma_is_coarser() const { return chroma_side != side; }
    LatticeStencil round_chroma(LatticePoint chroma) const { return lattice_stencil(side, chroma_side, chroma); }
    LatticeStencil round_sample(LatticePoint sample) const { return lattice_stencil(chroma_side, side, sample); }
  };
  const std::vector<Triangle>& triangles() const { return triangles_; }
  const Triangle& triangle_at(int first_sample) const;

  /// The rows that a sample's colour is made of.
  struct SampleRows {
    int luma;
    int chroma_count;
    int chroma[3];     ///< of the first colour difference
    float weights[3];  ///< of these
    int to_second;     ///< rows from a first colour difference to the second one
  };
  SampleRows rows_of_sample(const Triangle& triangle, int sample) const;
  /// value(row). The same values give the same colour to the last bit, wherever they come from.
  template <typename Value>
  static Eigen::Vector3f colour(const SampleRows& rows, const Value& value) {
    float chroma[2][3] = {};
    for (int k = 0; k < rows.chroma_count; ++k) {
      chroma[0][k] = value(rows.chroma[k]);
      chroma[1][k] = value(rows.chroma[k] + rows.to_second);
    }
    return joined(value(rows.luma), chroma, rows.weights);
  }

 private:
  static Eigen::Vector3f joined(float luma, const float (&chroma)[2][3], const float (&weights)[3]);

  std::vector<Triangle> triangles_;
  int samples_ = 0, chroma_samples_ = 0;
};

}  // namespace sheen
