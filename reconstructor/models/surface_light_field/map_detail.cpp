// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/map_detail.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <utility>

#include "reconstructor/surface/lattice_resampling.h"
#include "reconstructor/surface/map_layout.h"

namespace sheen {
namespace {

constexpr int kChannels = 3;
constexpr int kSmallestSide = 3;  // a map of corners alone knows nothing of what is inside
constexpr int kHalvings = 2;      // at once

/// With every second interval, or so.
int half_side(int side) {
  return std::max(std::min(side, kSmallestSide), side / 2 + 1);
}

using Map = Eigen::Map<const Eigen::Matrix3Xf>;

/// The components of what is displayed, the strongest first: rows x components, so that their squares add up to those
/// of all that is displayed.
Eigen::MatrixXf components(const Eigen::MatrixXf& basis, const Eigen::MatrixXf& displayed) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> eigen(displayed * displayed.transpose());
  const Eigen::VectorXf scale = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
  return basis * (eigen.eigenvectors() * scale.asDiagonal()).rowwise().reverse();
}

/// Whether a coarser map misses less than that much of the components' squares.
bool is_enough(const LatticeResampling& coarser, const Eigen::Ref<const Eigen::MatrixXf>& map, float most) {
  float missed = 0;
  for (Eigen::Index k = 0; k < map.cols() && missed <= most; ++k) {
    const Map values(map.col(k).data(), kChannels, map.rows() / kChannels);
    missed += coarser.missed(values).squaredNorm();
  }
  return missed <= most;
}

}  // namespace

RowResampling resampled_maps(const MapSides& from, const MapSides& to) {
  RowResampling resampling;
  int first = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const int samples = lattice_samples(to[i]);
    for (int s = 0; s < samples; ++s) {
      const LatticeStencil& round = lattice_resampling(from[i], to[i]).round(s);
      std::array<int, 3> between{};
      for (std::size_t k = 0; k < 3; ++k) {
        const bool counts = round.weight[k] > 1e-3f;
        between[k] = first + (counts ? round.index[k] : lattice_resampling(from[i], to[i]).nearest(s));
      }
      resampling.between.push_back(between);
    }
    first += lattice_samples(from[i]);
    resampling.rows += kChannels * samples;
  }
  resampling.columns = [from, to, rows = resampling.rows](const Eigen::MatrixXf& columns) {
    Eigen::MatrixXf resampled(rows, columns.cols());
    for (Eigen::Index k = 0; k < columns.cols(); ++k) {
      const float* old = columns.col(k).data();
      float* fresh = resampled.col(k).data();
      for (std::size_t i = 0; i < from.size(); ++i) {
        const int samples = lattice_samples(from[i]), wanted = lattice_samples(to[i]);
        const Map values(old, kChannels, samples);
        Eigen::Map<Eigen::Matrix3Xf> out(fresh, kChannels, wanted);
        if (from[i] == to[i])
          out = values;
        else
          out = lattice_resampling(from[i], to[i]).of(values);
        old += kChannels * samples;
        fresh += kChannels * wanted;
      }
    }
    return resampled;
  };
  return resampling;
}

MapSides sufficient_sides(const MapSides& sides, const Eigen::MatrixXf& basis, const Eigen::MatrixXf& displayed,
                          float detail) {
  MapSides sufficient = sides;
  const Eigen::MatrixXf strongest_first = components(basis, displayed);
  Eigen::Index first = 0;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Eigen::Index rows = kChannels * lattice_samples(sides[i]);
    const float most = detail * detail * static_cast<float>(rows * displayed.cols());
    int side = sides[i];
    for (int halving = 0; halving < kHalvings; ++halving) {
      side = half_side(side);
      if (side >= sufficient[i] ||
          !is_enough(lattice_resampling(sides[i], side), strongest_first.middleRows(first, rows), most))
        break;
      sufficient[i] = static_cast<std::uint8_t>(side);
    }
    first += rows;
  }
  return sufficient;
}

}  // namespace sheen
