// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace sheen {

/// The frequencies of a triangle's lattice of samples: eigenvectors of the Laplacian of the graph in which neighbouring
/// samples are joined, from the smoothest on. Orthonormal. Lattices with more than 24 samples on a side are cut into
/// tiles of 16 at most that have their own.
struct LatticeSpectrum {
  struct Tile {
    std::vector<int> samples;                        ///< of the triangle
    std::shared_ptr<const Eigen::MatrixXf> vectors;  ///< samples x frequencies
  };
  std::vector<Tile> tiles;
};

/// `resolution` >= 2, as in `lattice_samples`. The same object every time.
const LatticeSpectrum& lattice_spectrum(int resolution);

}  // namespace sheen
