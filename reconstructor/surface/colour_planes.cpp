// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/colour_planes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr float kCounts = 1e-3f;  // a sample that weighs less says nothing of what lies between

using Triangle = ColourPlanes::Triangle;

/// Luma and colour differences of each sample of a triangle: 3 x samples.
Eigen::Matrix3Xf opponent(const Triangle& triangle, const ColourPlanes::ColumnRef& colours) {
  const int samples = lattice_samples(triangle.side);
  return opponent_colours() *
         Eigen::Map<const Eigen::Matrix3Xf>(colours.data() + 3 * triangle.first_sample, 3, samples);
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
Eigen::Vector3f continued(int side, float x, float y, float radius, const Eigen::Matrix3Xf& values,
                          std::span<const std::uint8_t> visible) {
  constexpr float kLevel = 0.001f;  // of a direction in which there are no samples nothing is known: it is level there
  Eigen::Matrix3f moments = Eigen::Matrix3f::Zero(), sums = Eigen::Matrix3f::Zero();  // of 1, x, y; times the values
  const auto first = [&](float at) { return std::max(0, static_cast<int>(std::ceil(at - radius))); };
  for (int i = first(x); static_cast<float>(i) <= x + radius; ++i)
    for (int j = first(y); static_cast<float>(j) <= y + radius && i + j < side; ++j) {
      const int sample = lattice_index(side, i, j);
      const float dx = static_cast<float>(i) - x, dy = static_cast<float>(j) - y;
      const float near = 1 - (dx * dx + dy * dy + dx * dy) / (radius * radius);
      if (near <= 0 || !visible[static_cast<std::size_t>(sample)]) continue;
      const Eigen::Vector3f place(1, dx, dy);
      moments += near * near * place * place.transpose();
      sums += near * near * place * values.col(sample).transpose();
    }
  if (moments(0, 0) == 0) return Eigen::Vector3f::Zero();
  moments.diagonal().tail<2>().array() += kLevel * moments(0, 0);
  return moments.llt().solve(sums).row(0).transpose();
}

/// Values of a triangle's samples at its chroma samples.
Eigen::Matrix3Xf on_chroma_lattice(const Triangle& triangle, const Eigen::Matrix3Xf& values,
                                   std::span<const std::uint8_t> visible) {
  Eigen::Matrix3Xf chroma = triangle.coarser->of(values);
  if (std::find(visible.begin(), visible.end(), 0) == visible.end()) return chroma;
  const float spacing = static_cast<float>(triangle.side - 1) / static_cast<float>(triangle.chroma_side - 1);
  for (int i = 0; i < triangle.chroma_side; ++i)
    for (int j = 0; i + j < triangle.chroma_side; ++j) {
      const int sample = lattice_index(triangle.chroma_side, i, j);
      if (all_visible(triangle.coarser->round(sample), visible)) continue;
      chroma.col(sample) = continued(triangle.side, spacing * static_cast<float>(i), spacing * static_cast<float>(j),
                                     2 * spacing, values, visible);
    }
  return chroma;
}

}  // namespace

const Eigen::Matrix3f& opponent_colours() {
  static const Eigen::Matrix3f colours = [] {
    Eigen::Matrix3f m;
    m << 1 / std::sqrt(3.0f), 1 / std::sqrt(3.0f), 1 / std::sqrt(3.0f),  //
        1 / std::sqrt(2.0f), 0, -1 / std::sqrt(2.0f),                    //
        1 / std::sqrt(6.0f), -2 / std::sqrt(6.0f), 1 / std::sqrt(6.0f);
    return m;
  }();
  return colours;
}

ColourPlanes::ColourPlanes(const MapSides& sides, const MapSides& chroma_sides) {
  triangles_.reserve(sides.size());
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool same = sides[i] == chroma_sides[i];
    triangles_.push_back({.side = sides[i],
                          .chroma_side = chroma_sides[i],
                          .first_sample = samples_,
                          .first_chroma = chroma_samples_,
                          .chroma_weight = std::sqrt(static_cast<float>(lattice_samples(sides[i])) /
                                                     static_cast<float>(lattice_samples(chroma_sides[i]))),
                          .coarser = same ? nullptr : &lattice_resampling(sides[i], chroma_sides[i]),
                          .finer = same ? nullptr : &lattice_resampling(chroma_sides[i], sides[i])});
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

Eigen::VectorXf ColourPlanes::rows_of(const ColumnRef& colours, std::span<const std::uint8_t> visible) const {
  Eigen::VectorXf rows(this->rows());
  for (const Triangle& triangle : triangles_) {
    Eigen::Matrix3Xf planes = opponent(triangle, colours);
    rows.segment(triangle.first_sample, planes.cols()) = planes.row(0);
    if (triangle.coarser) planes = on_chroma_lattice(triangle, planes, own_samples(triangle, visible));
    planes *= triangle.chroma_weight;
    rows.segment(samples_ + triangle.first_chroma, planes.cols()) = planes.row(1);
    rows.segment(samples_ + chroma_samples_ + triangle.first_chroma, planes.cols()) = planes.row(2);
  }
  return rows;
}

Eigen::VectorXf ColourPlanes::colours_of(const ColumnRef& rows, int first_sample) const {
  const Triangle& triangle = triangle_at(first_sample);
  Eigen::VectorXf colours(3 * lattice_samples(triangle.side));
  for (int sample = 0; 3 * sample < colours.size(); ++sample)
    colours.segment<3>(3 * sample) = colour(triangle, sample, [&](int row) { return rows[row]; });
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
  std::vector<std::uint8_t> known(samples.begin(), samples.end());
  known.reserve(static_cast<std::size_t>(samples_ + chroma_samples_));
  for (const Triangle& triangle : triangles_) {
    const auto own = own_samples(triangle, samples);
    for (int s = 0; s < lattice_samples(triangle.chroma_side); ++s)
      known.push_back(triangle.coarser ? all_visible(triangle.coarser->round(s), own)
                                       : own[static_cast<std::size_t>(s)] != 0);
  }
  return known;
}

std::vector<std::uint8_t> ColourPlanes::guessed_places(std::span<const std::uint8_t> samples) const {
  std::vector<std::uint8_t> known(samples.begin(), samples.end());
  known.resize(static_cast<std::size_t>(samples_ + chroma_samples_), 0);
  for (const Triangle& triangle : triangles_) {
    const auto own = own_samples(triangle, samples);
    std::uint8_t* const chroma = known.data() + samples_ + triangle.first_chroma;
    for (std::size_t s = 0; s < own.size(); ++s) {
      if (own[s] == 0) continue;
      if (!triangle.finer) {
        chroma[s] = 1;
        continue;
      }
      const LatticeStencil& round = triangle.finer->round(static_cast<int>(s));
      for (int k = 0; k < 3; ++k)
        if (round.weight[k] > kCounts) chroma[round.index[k]] = 1;
    }
  }
  return known;
}

std::vector<std::uint8_t> ColourPlanes::known_rows(std::span<const std::uint8_t> known_places) const {
  std::vector<std::uint8_t> known(known_places.begin(), known_places.end());
  known.insert(known.end(), known_places.begin() + samples_, known_places.end());
  return known;
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
    if (!triangle.coarser) continue;
    const auto own = own_samples(triangle, visible);
    const Eigen::Matrix3Xf planes = opponent(triangle, colours), missed = triangle.coarser->missed(planes);
    float square = 0;
    int values = 0;
    for (int s = 0; s < missed.cols(); ++s) {
      const LatticeStencil& round = triangle.finer->round(s);
      bool counts = own[static_cast<std::size_t>(s)] != 0;
      for (int k = 0; k < 3; ++k)
        counts = counts && (round.weight[k] <= kCounts || all_visible(triangle.coarser->round(round.index[k]), own));
      if (!counts) continue;
      square += missed.col(s).tail<2>().squaredNorm();
      values += 2;
    }
    if (square > most_missed * most_missed * static_cast<float>(values)) wanted[i] = triangle.side;
  }
  return wanted;
}

const Triangle& ColourPlanes::triangle_at(int first_sample) const {
  return *std::lower_bound(triangles_.begin(), triangles_.end(), first_sample,
                           [](const Triangle& triangle, int sample) { return triangle.first_sample < sample; });
}

/// Never inlined: how sums are rounded would depend on what stands round them.
[[gnu::noinline]] Eigen::Vector3f ColourPlanes::joined(float luma, const float (&chroma)[2][3],
                                                       const float (&weights)[3]) {
  Eigen::Vector3f planes(luma, 0, 0);
  for (int k = 0; k < 3; ++k) {
    planes[1] += weights[k] * chroma[0][k];
    planes[2] += weights[k] * chroma[1][k];
  }
  return opponent_colours().transpose() * planes;
}

}  // namespace sheen
