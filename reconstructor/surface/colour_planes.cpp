// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/colour_planes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "reconstructor/surface/lattice_resampling.h"

namespace sheen {
namespace {

// Of luma and of the colour differences, in what makes them up: 3^(-1/2), 2^(-1/2), 6^(-1/2).
constexpr float kLuma = 0.57735027f, kFirst = 0.70710678f, kSecond = 0.40824829f;
constexpr float kCounts = 1e-3f;  // a sample that weighs less says nothing of what lies between

using Triangle = ColourPlanes::Triangle;

using Colours = Eigen::Map<const Eigen::Matrix3Xf>;  ///< of a triangle, a sample each

Colours own_colours(const Triangle& triangle, const ColourPlanes::ColumnRef& colours) {
  return {colours.data() + 3 * triangle.first_sample, 3, lattice_samples(triangle.side)};
}

std::span<const std::uint8_t> own_samples(const Triangle& triangle, std::span<const std::uint8_t> samples) {
  return samples.subspan(static_cast<std::size_t>(triangle.first_sample),
                         static_cast<std::size_t>(lattice_samples(triangle.side)));
}

/// Whether those that a place between samples is interpolated from are visible.
bool all_visible(const LatticeStencil& round, std::span<const std::uint8_t> visible) {
  bool all = true;
  for (int k = 0; k < 3; ++k)
    all = all && (round.weight[k] <= kCounts || visible[static_cast<std::size_t>(round.index[k])] != 0);
  return all;
}

/// At a place (x, y) of a lattice, in samples, from those round it that are visible: what varies evenly goes on beyond
/// them. By moving least squares; zero where none is near.
Eigen::Vector3f continued(int side, float x, float y, float radius, const Colours& colours,
                          std::span<const std::uint8_t> visible) {
  constexpr float kLevel = 0.001f;  // of a direction in which there are no samples nothing is known: it is level there
  Eigen::Matrix3f moments = Eigen::Matrix3f::Zero(), sums = Eigen::Matrix3f::Zero();  // of 1, x, y; times colours
  const auto first = [&](float at) { return std::max(0, static_cast<int>(std::ceil(at - radius))); };
  for (int i = first(x); static_cast<float>(i) <= x + radius; ++i)
    for (int j = first(y); static_cast<float>(j) <= y + radius && i + j < side; ++j) {
      const int sample = lattice_index(side, i, j);
      const float dx = static_cast<float>(i) - x, dy = static_cast<float>(j) - y;
      const float near = 1 - (dx * dx + dy * dy + dx * dy) / (radius * radius);
      if (near <= 0 || !visible[static_cast<std::size_t>(sample)]) continue;
      const Eigen::Vector3f place(1, dx, dy);
      moments += near * near * place * place.transpose();
      sums += near * near * place * colours.col(sample).transpose();
    }
  if (moments(0, 0) == 0) return Eigen::Vector3f::Zero();
  moments.diagonal().tail<2>().array() += kLevel * moments(0, 0);
  return moments.llt().solve(sums).row(0).transpose();
}

/// visit(point, its index) of a lattice.
template <typename Visit>
void visit_points(int side, const Visit& visit) {
  for (int i = 0, index = 0; i < side; ++i)
    for (int j = 0; i + j < side; ++j, ++index) visit(LatticePoint{i, j}, index);
}

Eigen::Vector3f colour_at_chroma(const Triangle& triangle, LatticePoint chroma, const Colours& colours,
                                 std::span<const std::uint8_t> visible) {
  const LatticeStencil round = triangle.round_chroma(chroma);
  if (all_visible(round, visible))
    return round.weight[0] * colours.col(round.index[0]) + round.weight[1] * colours.col(round.index[1]) +
           round.weight[2] * colours.col(round.index[2]);
  const float spacing = static_cast<float>(triangle.side - 1) / static_cast<float>(triangle.chroma_side - 1);
  return continued(triangle.side, spacing * static_cast<float>(chroma.i), spacing * static_cast<float>(chroma.j),
                   2 * spacing, colours, visible);
}

/// Whether the samples round a chroma sample are visible.
bool is_known(const Triangle& triangle, LatticePoint chroma, int index, std::span<const std::uint8_t> visible) {
  return triangle.chroma_is_coarser() ? all_visible(triangle.round_chroma(chroma), visible)
                                      : visible[static_cast<std::size_t>(index)] != 0;
}

}  // namespace

const Eigen::Matrix3f& opponent_colours() {
  static const Eigen::Matrix3f colours = [] {
    Eigen::Matrix3f m;
    m << kLuma, kLuma, kLuma,  //
        kFirst, 0, -kFirst,    //
        kSecond, -2 * kSecond, kSecond;
    return m;
  }();
  return colours;
}

ColourPlanes::ColourPlanes(const MapSides& sides, const MapSides& chroma_sides) {
  triangles_.reserve(sides.size());
  for (std::size_t i = 0; i < sides.size(); ++i) {
    triangles_.push_back({.side = sides[i],
                          .chroma_side = chroma_sides[i],
                          .first_sample = samples_,
                          .first_chroma = chroma_samples_,
                          .chroma_weight = std::sqrt(static_cast<float>(lattice_samples(sides[i])) /
                                                     static_cast<float>(lattice_samples(chroma_sides[i])))});
    samples_ += lattice_samples(sides[i]);
    chroma_samples_ += lattice_samples(chroma_sides[i]);
  }
}

MapSides ColourPlanes::sides() const {
  MapSides sides;
  for (const Triangle& triangle : triangles_) sides.push_back(triangle.side);
  return sides;
}

MapSides ColourPlanes::chroma_sides() const {
  MapSides sides;
  for (const Triangle& triangle : triangles_) sides.push_back(triangle.chroma_side);
  return sides;
}

namespace {

/// What of each colour lies along an axis.
void project(const Colours& colours, const Eigen::Vector3f& axis, float* out) {
  const float* colour = colours.data();
  for (Eigen::Index s = 0; s < colours.cols(); ++s, colour += 3)
    out[s] = axis[0] * colour[0] + axis[1] * colour[1] + axis[2] * colour[2];
}

}  // namespace

Eigen::VectorXf ColourPlanes::rows_of(const ColumnRef& colours, std::span<const std::uint8_t> visible) const {
  const Eigen::Matrix3f& planes = opponent_colours();
  Eigen::VectorXf rows(this->rows());
  for (const Triangle& triangle : triangles_) {
    const Colours own = own_colours(triangle, colours);
    const auto own_visible = own_samples(triangle, visible);
    project(own, planes.row(0), rows.data() + triangle.first_sample);
    float* const first = rows.data() + samples_ + triangle.first_chroma;
    float* const second = first + chroma_samples_;
    if (!triangle.chroma_is_coarser()) {
      project(own, planes.row(1), first);
      project(own, planes.row(2), second);
      continue;
    }
    visit_points(triangle.chroma_side, [&](LatticePoint chroma, int c) {
      const Eigen::Vector3f colour = colour_at_chroma(triangle, chroma, own, own_visible);
      first[c] = triangle.chroma_weight * planes.row(1).dot(colour);
      second[c] = triangle.chroma_weight * planes.row(2).dot(colour);
    });
  }
  return rows;
}

Eigen::VectorXf ColourPlanes::colours_of(const ColumnRef& rows, int first_sample) const {
  const Triangle& triangle = triangle_at(first_sample);
  Eigen::VectorXf colours(3 * lattice_samples(triangle.side));
  for (int sample = 0; 3 * sample < colours.size(); ++sample)
    colours.segment<3>(3 * sample) = colour(rows_of_sample(triangle, sample), [&](int row) { return rows[row]; });
  return colours;
}

Eigen::VectorXf ColourPlanes::colours_of(const ColumnRef& rows) const {
  Eigen::VectorXf colours(3 * samples_);
  for (const Triangle& triangle : triangles_)
    colours.segment(3 * triangle.first_sample, 3 * lattice_samples(triangle.side)) =
        colours_of(rows, triangle.first_sample);
  return colours;
}

std::vector<std::uint8_t> ColourPlanes::known_places(std::span<const std::uint8_t> samples) const {
  std::vector<std::uint8_t> known;
  known.reserve(static_cast<std::size_t>(rows()));  // for `known_rows`
  known.assign(samples.begin(), samples.end());
  for (const Triangle& triangle : triangles_) {
    const auto own = own_samples(triangle, samples);
    visit_points(triangle.chroma_side,
                 [&](LatticePoint chroma, int index) { known.push_back(is_known(triangle, chroma, index, own)); });
  }
  return known;
}

std::vector<std::uint8_t> ColourPlanes::guessed_places(std::span<const std::uint8_t> samples) const {
  std::vector<std::uint8_t> known(samples.begin(), samples.end());
  known.resize(static_cast<std::size_t>(samples_ + chroma_samples_), 0);
  for (const Triangle& triangle : triangles_) {
    const auto own = own_samples(triangle, samples);
    std::uint8_t* const chroma = known.data() + samples_ + triangle.first_chroma;
    if (!triangle.chroma_is_coarser()) {
      std::copy(own.begin(), own.end(), chroma);
      continue;
    }
    visit_points(triangle.side, [&](LatticePoint sample, int s) {
      if (own[static_cast<std::size_t>(s)] == 0) return;
      const LatticeStencil round = triangle.round_sample(sample);
      for (int k = 0; k < 3; ++k)
        if (round.weight[k] > kCounts) chroma[round.index[k]] = 1;
    });
  }
  return known;
}

std::vector<std::uint8_t> ColourPlanes::known_rows(std::vector<std::uint8_t> known_places) const {
  known_places.resize(static_cast<std::size_t>(rows()));
  const auto first_difference = known_places.begin() + samples_;
  std::copy_n(first_difference, chroma_samples_, first_difference + chroma_samples_);
  return known_places;
}

Eigen::MatrixXf ColourPlanes::mean_colours(const Eigen::Ref<const Eigen::MatrixXf>& columns,
                                           std::span<const std::uint8_t> known_places) const {
  Eigen::MatrixXf mean = Eigen::MatrixXf::Zero(3, columns.cols());
  int samples = 0, chroma_samples = 0;
  for (const Triangle& triangle : triangles_) {
    for (int row = triangle.first_sample; row < triangle.first_sample + lattice_samples(triangle.side); ++row) {
      if (!known_places[static_cast<std::size_t>(row)]) continue;
      mean.row(0) += columns.row(row);
      ++samples;
    }
    const int first = samples_ + triangle.first_chroma;
    for (int row = first; row < first + lattice_samples(triangle.chroma_side); ++row) {
      if (!known_places[static_cast<std::size_t>(row)]) continue;
      mean.row(1) += columns.row(row) / triangle.chroma_weight;
      mean.row(2) += columns.row(row + chroma_samples_) / triangle.chroma_weight;
      ++chroma_samples;
    }
  }
  mean.topRows(1) /= static_cast<float>(std::max(samples, 1));
  mean.bottomRows(2) /= static_cast<float>(std::max(chroma_samples, 1));
  return opponent_colours().transpose() * mean;
}

Eigen::MatrixXf ColourPlanes::chroma_of(const Eigen::Ref<const Eigen::MatrixXf>& columns) const {
  Eigen::MatrixXf chroma = columns.bottomRows(2 * chroma_samples_);
  for (const Triangle& triangle : triangles_)
    for (const int first : {0, chroma_samples_})
      chroma.middleRows(first + triangle.first_chroma, lattice_samples(triangle.chroma_side)) /= triangle.chroma_weight;
  return chroma;
}

MapSides ColourPlanes::sides_for_chroma_of(const ColumnRef& colours, std::span<const std::uint8_t> visible,
                                           float most_missed) const {
  MapSides wanted = chroma_sides();
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    const Triangle& triangle = triangles_[i];
    if (!triangle.chroma_is_coarser()) continue;
    const auto own = own_samples(triangle, visible);
    const Eigen::Matrix3Xf missed = LatticeResampling(triangle.side, triangle.chroma_side)
                                        .missed(opponent_colours() * own_colours(triangle, colours));
    std::vector<std::uint8_t> known;
    visit_points(triangle.chroma_side,
                 [&](LatticePoint chroma, int index) { known.push_back(is_known(triangle, chroma, index, own)); });
    float square = 0;
    int values = 0;
    visit_points(triangle.side, [&](LatticePoint sample, int s) {
      if (own[static_cast<std::size_t>(s)] == 0 || !all_visible(triangle.round_sample(sample), known)) return;
      square += missed.col(s).tail<2>().squaredNorm();
      values += 2;
    });
    if (square > most_missed * most_missed * static_cast<float>(values)) wanted[i] = triangle.side;
  }
  return wanted;
}

const Triangle& ColourPlanes::triangle_at(int first_sample) const {
  return *std::lower_bound(triangles_.begin(), triangles_.end(), first_sample,
                           [](const Triangle& triangle, int sample) { return triangle.first_sample < sample; });
}

ColourPlanes::SampleRows ColourPlanes::rows_of_sample(const Triangle& triangle, int sample) const {
  const int first = samples_ + triangle.first_chroma;
  SampleRows rows{triangle.first_sample + sample, 1, {first + sample, 0, 0}, {1, 0, 0}, chroma_samples_};
  if (!triangle.chroma_is_coarser()) return rows;
  const LatticeStencil round = triangle.round_sample(lattice_point(triangle.side, sample));
  rows.chroma_count = 3;
  for (int k = 0; k < 3; ++k) {
    rows.chroma[k] = first + round.index[k];
    rows.weights[k] = round.weight[k] / triangle.chroma_weight;
  }
  return rows;
}

/// Never inlined: how sums are rounded would depend on what stands round them.
[[gnu::noinline]] Eigen::Vector3f ColourPlanes::joined(float luma, const float (&chroma)[2][3],
                                                       const float (&weights)[3]) {
  float differences[2];
  for (int d = 0; d < 2; ++d)
    differences[d] = weights[0] * chroma[d][0] + weights[1] * chroma[d][1] + weights[2] * chroma[d][2];
  const float grey = kLuma * luma, first = kFirst * differences[0], second = kSecond * differences[1];
  return {grey + first + second, grey - 2 * second, grey - first + second};
}

}  // namespace sheen
