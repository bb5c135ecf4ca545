// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/map_layout.h"

#include <algorithm>
#include <utility>

namespace sheen {

LatticeStencil lattice_stencil(int n, float u, float v) {
  const float fu = std::clamp(u, 0.0f, 1.0f) * (n - 1),
              fv = std::clamp(v, 0.0f, 1.0f - std::clamp(u, 0.0f, 1.0f)) * (n - 1);
  const int i = std::min(static_cast<int>(fu), n - 2);
  const int j = std::min(static_cast<int>(fv), n - 2 - i);
  const float a = fu - i, b = fv - j;
  if (a + b <= 1 || i + j + 2 > n - 1) {    // the lower half of the cell, the only one at the lattice's long edge
    const float s = std::max(1.0f, a + b);  // rounding may put a point a hair outside
    return {{lattice_index(n, i, j), lattice_index(n, i + 1, j), lattice_index(n, i, j + 1)},
            {std::max(0.0f, 1 - a - b), a / s, b / s}};
  }
  return {{lattice_index(n, i + 1, j + 1), lattice_index(n, i, j + 1), lattice_index(n, i + 1, j)},
          {a + b - 1, 1 - a, 1 - b}};
}

MapLayout::MapLayout(std::vector<std::uint8_t> resolution, std::vector<std::uint8_t> filter_resolution)
    : resolution_(std::move(resolution)), filter_resolution_(std::move(filter_resolution)) {
  first_.reserve(resolution_.size() + 1);
  first_.push_back(0);
  for (const std::uint8_t n : resolution_)
    first_.push_back(first_.back() + static_cast<std::size_t>(lattice_samples(n)));
}

std::size_t MapLayout::bytes() const {
  return (resolution_.size() + filter_resolution_.size()) * sizeof(std::uint8_t) + first_.size() * sizeof(std::size_t);
}

}  // namespace sheen
