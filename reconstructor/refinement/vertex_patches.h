// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"

namespace sheen {

/// A patch is a square grid of points of the surface round a vertex: kPatchSide x kPatchSide, row by row.
inline constexpr int kPatchSide = 7;
inline constexpr int kPatchPoints = kPatchSide * kPatchSide;
/// Points of a patch at its corners and its middle.
inline constexpr std::array<int, 5> kPatchProbes{0, kPatchSide - 1, kPatchPoints / 2, kPatchPoints - kPatchSide,
                                                 kPatchPoints - 1};

/// What does not change while the vertices move.
struct MeshEdges {
  explicit MeshEdges(const Mesh& mesh);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;  ///< each once, lower vertex first
  std::vector<std::size_t> first;                              ///< into `neighbours`; one more than vertices
  std::vector<std::uint32_t> neighbours;

  std::span<const std::uint32_t> around(std::size_t vertex) const {
    return std::span(neighbours).subspan(first[vertex], first[vertex + 1] - first[vertex]);
  }
};

/// Values of the vertices, each mixed half with the mean of its neighbours, `times` times.
std::vector<Eigen::Vector3f> smoothed(std::vector<Eigen::Vector3f> values, const MeshEdges& edges, int times);

/// Width on the surface of a pixel that looks straight at it, metres: mean over the cameras that a vertex faces, of all
/// cameras where it faces none.
std::vector<float> pixel_footprints(const Mesh& mesh, std::span<const PosedCamera> cameras);

/// A patch for each vertex. Its points lie on the mesh as smoothing leaves it, so that a vertex that stands out by
/// itself does not bend the patches round it.
struct VertexPatches {
  /// `spacing`: between neighbouring points of a vertex's patch, metres, per vertex. `smoothing`: how often; each time
  /// rounds off edges that the object may have.
  VertexPatches(const Mesh& mesh, const MeshEdges& edges, std::vector<float> spacing, int smoothing);
  /// The same of some vertices of the mesh, in this order: `spacing` and all below is of these.
  VertexPatches(const Mesh& mesh, const MeshEdges& edges, std::span<const std::uint32_t> vertices,
                std::vector<float> spacing, int smoothing);

  std::vector<Eigen::Vector3f> normals;  ///< unit; a vertex and its patch move along it
  std::vector<float> spacing;
  std::vector<Eigen::Vector3f> offsets;  ///< kPatchPoints per vertex, from the vertex

  std::span<const Eigen::Vector3f> of(std::size_t vertex) const {
    return std::span(offsets).subspan(vertex * kPatchPoints, kPatchPoints);
  }
};

}  // namespace sheen
