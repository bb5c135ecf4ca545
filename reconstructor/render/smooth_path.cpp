// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/smooth_path.h"

#include <algorithm>

namespace sheen {
namespace {

using Eigen::Vector3d;

Vector3d catmull_rom(const Vector3d& before, const Vector3d& a, const Vector3d& b, const Vector3d& after, double t) {
  const Vector3d start = (b - before) / 2, end = (after - a) / 2;
  return a + t * (start + t * (3 * (b - a) - 2 * start - end + t * (2 * (a - b) + start + end)));
}

}  // namespace

std::vector<Vector3d> smooth_path(std::span<const Vector3d> keys, int frames, bool closed) {
  const auto count = static_cast<std::ptrdiff_t>(keys.size()), legs = closed ? count : count - 1;
  const auto key = [&](std::ptrdiff_t k) -> const Vector3d& {
    return keys[static_cast<std::size_t>(closed ? (k + count) % count : std::clamp<std::ptrdiff_t>(k, 0, count - 1))];
  };
  std::vector<Vector3d> path;
  for (int i = 0; i < frames; ++i) {
    const double at = static_cast<double>(legs) * i / (closed ? frames : frames - 1);
    const auto k = std::min(static_cast<std::ptrdiff_t>(at), legs - 1);
    path.push_back(catmull_rom(key(k - 1), key(k), key(k + 1), key(k + 2), at - static_cast<double>(k)));
  }
  return path;
}

}  // namespace sheen
