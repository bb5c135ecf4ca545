// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sheen {

/// Polygons that are not convex take time with the square of their corners, or more.
inline constexpr std::size_t kMostCorners = 10'000;

/// Splits a polygon into triangles of its own corners, always two fewer than it has corners: convex ones into a fan,
/// others by clipping ears (Meisters, "Polygons have ears", 1975). Corners may lie in line or coincide, the polygon may
/// touch itself (a bridge to a hole) and be a little bent; one that crosses itself is covered somehow. Triangles turn
/// as it does. Empty: it is not convex and has more than `kMostCorners`.
std::vector<std::array<std::uint32_t, 3>> polygon_triangles(std::span<const Eigen::Vector3d> corners);

}  // namespace sheen
