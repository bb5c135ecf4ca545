// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/geometry/mesh.h"
#include "reconstructor/surface/map_layout.h"

namespace sheen {

/// Triangles that share one basis.
struct PatchShape {
  std::span<const std::uint32_t> triangles;  ///< ascending; its samples are theirs, one triangle after the other
  std::span<const std::uint32_t> vertices;   ///< corners of the triangles, ascending
  std::uint32_t samples = 0;
};

/// A vertex of a patch: the patch, and which of `PatchShape::vertices`.
struct PatchVertex {
  std::uint32_t patch;
  std::uint32_t vertex;
};

/// What a triangle is drawn with.
struct TrianglePlace {
  std::uint32_t patch;
  std::uint32_t first_sample;            ///< of the triangle's samples among the patch's
  std::array<std::uint32_t, 3> columns;  ///< of `LightFieldSnapshot::coefficients_for`, for its corners
};

/// The triangles of all patches, and their vertices, a patch after the other: the same on any maps.
struct PatchMembers {
  std::vector<std::uint32_t> triangles, vertices;
};

/// A mesh cut into patches.
struct PatchShapes {
  std::vector<PatchShape> patches;
  std::shared_ptr<const PatchMembers> members;  ///< what the patches refer to
  std::vector<std::uint32_t> patch_of;          ///< per triangle
  std::vector<std::uint32_t> first_sample;      ///< per triangle, in its patch

  /// The vertices of all patches in a row, a patch after the other: what view coefficients are numbered by.
  std::vector<std::uint32_t> first_column;   ///< per patch, and behind the last: of its vertices
  std::vector<std::uint32_t> corner_column;  ///< three per triangle: of its corner in its patch
  std::size_t columns() const { return first_column.back(); }
  TrianglePlace place(std::size_t triangle) const {
    const std::uint32_t* const columns = &corner_column[3 * triangle];
    return {patch_of[triangle], first_sample[triangle], {columns[0], columns[1], columns[2]}};
  }

  /// The patches that have the vertex.
  std::span<const PatchVertex> round(std::size_t vertex) const {
    return std::span(patch_vertices).subspan(first_round[vertex], first_round[vertex + 1] - first_round[vertex]);
  }
  std::vector<PatchVertex> patch_vertices;  ///< by vertex
  std::vector<std::uint32_t> first_round;   ///< per vertex, and behind the last
};

/// `patch_of`: for each triangle its patch; of 0 .. n - 1, each must have a triangle.
PatchShapes patch_shapes(const Mesh& mesh, const MapLayout& maps, std::vector<std::uint32_t> patch_of);

/// The same patches on maps of other resolutions.
PatchShapes with_maps(PatchShapes shapes, const MapLayout& maps);

/// How many triangles a patch has, where its surroundings have them; of fine triangles it has more, until it has so
/// many samples.
struct PatchSize {
  std::size_t triangles = 1;
  std::size_t samples = 0;
};

/// Patches of neighbouring triangles. They depend on connections and numbers of samples alone, in whole numbers, so
/// that a reader cuts a mesh the same way.
PatchShapes cut_into_patches(const Mesh& mesh, const MapLayout& maps, const PatchSize& size);

}  // namespace sheen
