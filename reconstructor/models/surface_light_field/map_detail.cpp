// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/map_detail.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <utility>
#include <vector>

#include "reconstructor/surface/lattice_resampling.h"
#include "reconstructor/surface/map_layout.h"

namespace sheen {
namespace {

constexpr int kChannels = 3;
constexpr int kSmallestSide = 3;  // a map of corners alone knows nothing of what is inside
constexpr int kHalvings = 2;      // at once

/// The components of what is displayed, the strongest first: rows x components, so that their squares add up to those
/// of all that is displayed.
Eigen::MatrixXf components(const Eigen::MatrixXf& basis, const Eigen::MatrixXf& displayed) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> eigen(displayed * displayed.transpose());
  const Eigen::VectorXf scale = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
  return basis * (eigen.eigenvectors() * scale.asDiagonal()).rowwise().reverse();
}

/// Whether coarser maps miss less than that much of the components' squares. `first_rows`: of the map in each plane.
bool is_enough(const LatticeResampling& coarser, const Eigen::MatrixXf& components,
               const std::vector<Eigen::Index>& first_rows, Eigen::Index samples, float most) {
  float missed = 0;
  for (Eigen::Index k = 0; k < components.cols() && missed <= most; ++k)
    for (const Eigen::Index first : first_rows)
      missed += coarser.missed_of_plane(components.col(k).segment(first, samples)).squaredNorm();
  return missed <= most;
}

/// A map of a plane: rows `first_row` on, on a lattice of this side.
struct PlaneMap {
  int side, first_row;
  float weight;  ///< of its values
};

/// Luma's, then those of either colour difference, a triangle after the other.
std::vector<PlaneMap> maps_of(const ColourPlanes& planes) {
  std::vector<PlaneMap> maps;
  for (const ColourPlanes::Triangle& triangle : planes.triangles())
    maps.push_back({triangle.side, triangle.first_sample, 1});
  for (const int first : {planes.samples(), planes.samples() + planes.chroma_samples()})
    for (const ColourPlanes::Triangle& triangle : planes.triangles())
      maps.push_back({triangle.chroma_side, first + triangle.first_chroma, triangle.chroma_weight});
  return maps;
}

}  // namespace

int half_side(int side) {
  return std::max(std::min(side, kSmallestSide), side / 2 + 1);
}

MapSides half_sides(const MapSides& sides) {
  MapSides halves;
  for (const std::uint8_t side : sides) halves.push_back(static_cast<std::uint8_t>(half_side(side)));
  return halves;
}

RowResampling resampled_planes(const ColourPlanes& from, const ColourPlanes& to) {
  const std::vector<PlaneMap> before = maps_of(from), after = maps_of(to);
  std::vector<LatticeResampling> lattices;
  for (std::size_t i = 0; i < after.size(); ++i) lattices.emplace_back(before[i].side, after[i].side);
  RowResampling resampling{.rows = to.row_planes(), .columns = {}, .between = {}};
  resampling.between.reserve(static_cast<std::size_t>(to.rows()));
  for (std::size_t i = 0; i < after.size(); ++i) {
    for (int s = 0; s < lattice_samples(after[i].side); ++s) {
      const LatticeStencil& round = lattices[i].round(s);
      std::array<int, 3> between{};
      for (std::size_t k = 0; k < 3; ++k) {
        const bool counts = round.weight[k] > 1e-3f;
        between[k] = before[i].first_row + (counts ? round.index[k] : lattices[i].nearest(s));
      }
      resampling.between.push_back(between);
    }
  }
  resampling.columns = [before, after, lattices = std::move(lattices),
                        rows = to.rows()](const Eigen::MatrixXf& columns) {
    Eigen::MatrixXf resampled(rows, columns.cols());
    for (std::size_t i = 0; i < after.size(); ++i) {
      const auto [side, first, weight] = before[i];
      for (Eigen::Index k = 0; k < columns.cols(); ++k) {
        const auto values = columns.col(k).segment(first, lattice_samples(side));
        auto fresh = resampled.col(k).segment(after[i].first_row, lattice_samples(after[i].side));
        if (side == after[i].side)
          fresh = values;
        else
          fresh = lattices[i].of_plane(values);
        fresh *= after[i].weight / weight;
      }
    }
    return resampled;
  };
  return resampling;
}

MapSides sufficient_sides(const MapSides& sides, const Eigen::MatrixXf& basis, const Eigen::MatrixXf& displayed,
                          float detail) {
  MapSides sufficient = sides;
  Eigen::Index plane = 0;
  for (const std::uint8_t side : sides) plane += lattice_samples(side);
  const Eigen::MatrixXf strongest_first = components(basis, displayed);
  Eigen::Index first = 0;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Eigen::Index samples = lattice_samples(sides[i]);
    std::vector<Eigen::Index> first_rows;
    for (Eigen::Index row = first; row < basis.rows(); row += plane) first_rows.push_back(row);
    const float most = detail * detail * static_cast<float>(kChannels * samples * displayed.cols());
    int side = sides[i];
    for (int halving = 0; halving < kHalvings; ++halving) {
      side = half_side(side);
      if (side >= sufficient[i] ||
          !is_enough(LatticeResampling(sides[i], side), strongest_first, first_rows, samples, most))
        break;
      sufficient[i] = static_cast<std::uint8_t>(side);
    }
    first += samples;
  }
  return sufficient;
}

}  // namespace sheen
