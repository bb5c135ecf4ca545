// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "reconstructor/shape/block_field.h"

namespace sheen {

/// A cube of points^3 points from -half to half on each axis.
inline Lattice centred_lattice(int points, double half) {
  return {
      .origin = Eigen::Vector3d::Constant(-half), .cell = 2 * half / (points - 1), .points = {points, points, points}};
}

/// The distance that `distance(place)` gives, in the blocks that have a point nearer than `band` cells to the surface.
template <typename Distance>
BlockField field_of(const Lattice& lattice, double band, const Distance& distance) {
  BlockField field(lattice);
  std::array<float, BlockField::kBlockPoints> values;
  for (int z = 0; z < field.blocks().z(); ++z)
    for (int y = 0; y < field.blocks().y(); ++y)
      for (int x = 0; x < field.blocks().x(); ++x) {
        const Eigen::Array3i block(x, y, z);
        bool near = false;
        for (int i = 0; i < BlockField::kBlockPoints; ++i) {
          const Eigen::Array3i place(i % 8, i / 8 % 8, i / 64);
          values[i] = static_cast<float>(distance(lattice.at(8 * block + place)));
          near = near || !(std::abs(values[i]) > band * lattice.cell);
        }
        if (near) std::copy(values.begin(), values.end(), field.store(block));
        if (!near) field.fill(block, values[0] < 0);
      }
  return field;
}

}  // namespace sheen
