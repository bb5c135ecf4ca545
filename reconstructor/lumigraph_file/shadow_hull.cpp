// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/lumigraph_file/shadow_hull.h"

#include <limits>

namespace sheen {
namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr float kHiding = 0.25f * ShadowHull::kSolid;  // what is more solid hides the lamp
constexpr int kLayer = 3;  // cells that a surface may be thicker than the clearance, where depth is wrong

}  // namespace

float ShadowHull::solidity(const Vector3f& place) const {
  const Vector3f at = (place - origin_) / cell_ - Vector3f::Constant(0.5f);
  const Vector3i first = at.array().floor().cast<int>();
  if ((first.array() < 0).any() || (first.array() + 1 >= size_.array()).any()) return -1;
  const Vector3f part = at - first.cast<float>();
  const std::size_t row = static_cast<std::size_t>(size_.x()), sheet = row * static_cast<std::size_t>(size_.y());
  const std::uint8_t* cell = cells_.data() + static_cast<std::size_t>(first.x()) +
                             row * static_cast<std::size_t>(first.y()) + sheet * static_cast<std::size_t>(first.z());
  const auto between = [](float a, float b, float t) { return a + t * (b - a); };
  const auto along_x = [&](const std::uint8_t* c) { return between(c[0], c[1], part.x()); };
  const auto on_sheet = [&](const std::uint8_t* c) { return between(along_x(c), along_x(c + row), part.y()); };
  return between(on_sheet(cell), on_sheet(cell + sheet), part.z());
}

bool ShadowHull::hides(const Vector3f& point, const Lamp& lamp) const {
  if (empty()) return false;
  const Vector3f towards = lamp.towards(point);
  const float distance = lamp.kind == LightKind::kPoint ? towards.norm() / cell_ : std::numeric_limits<float>::max();
  const Vector3f step = cell_ * towards.normalized();
  int layer = kLayer;
  for (float passed = kHullClearance; passed < distance; ++passed) {
    const float found = solidity(point + passed * step);
    if (found < 0) return false;  // outside
    const bool solid = found > kHiding;
    if (solid && layer == 0) return true;
    layer = solid ? layer - 1 : 0;
  }
  return false;
}

}  // namespace sheen
