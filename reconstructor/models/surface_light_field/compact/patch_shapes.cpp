// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/patch_shapes.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "reconstructor/models/surface_light_field/compact/triangle_edges.h"

namespace sheen {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// For each triangle those that share an edge with it: any number, where the mesh is odd.
std::vector<std::vector<std::uint32_t>> neighbours_of(const Mesh& mesh) {
  const std::vector<TriangleEdge> edges = triangle_edges(mesh);
  std::vector<std::vector<std::uint32_t>> neighbours(mesh.triangles.size());
  for (std::size_t i = 1; i < edges.size(); ++i)
    if (edges[i].same_place(edges[i - 1])) {
      neighbours[edges[i].triangle].push_back(edges[i - 1].triangle);
      neighbours[edges[i - 1].triangle].push_back(edges[i].triangle);
    }
  return neighbours;
}

}  // namespace

/// From triangle to triangle: a patch takes the free neighbour that has most corners in it already, the earliest of
/// equals. What is left over goes to the smallest patch beside it.
PatchShapes cut_into_patches(const Mesh& mesh, const VertexRings& rings, std::size_t most_triangles) {
  const auto neighbours = neighbours_of(mesh);
  const std::size_t count = mesh.triangles.size();
  std::vector<std::uint32_t> patch_of(count, kNone);
  std::vector<std::vector<std::uint32_t>> members;
  for (std::uint32_t seed = 0; seed < count; ++seed) {
    if (patch_of[seed] != kNone) continue;
    const auto patch = static_cast<std::uint32_t>(members.size());
    std::vector<std::uint32_t> grown{seed};
    patch_of[seed] = patch;
    while (grown.size() < most_triangles) {
      std::uint32_t best = kNone;
      std::size_t best_corners = 0;
      for (const std::uint32_t from : grown)
        for (const std::uint32_t t : neighbours[from]) {
          if (patch_of[t] != kNone) continue;
          std::size_t corners = 0;
          for (const std::uint32_t member : grown)
            for (const std::uint32_t v : mesh.triangles[member])
              corners += std::count(mesh.triangles[t].begin(), mesh.triangles[t].end(), v) > 0;
          if (corners > best_corners || (corners == best_corners && t < best)) {
            best = t;
            best_corners = corners;
          }
        }
      if (best == kNone) break;
      patch_of[best] = patch;
      grown.push_back(best);
    }
    members.push_back(std::move(grown));
  }
  for (std::uint32_t patch = 0; patch < members.size(); ++patch) {
    if (4 * members[patch].size() > most_triangles) continue;
    std::uint32_t into = kNone;
    for (const std::uint32_t t : members[patch])
      for (const std::uint32_t other : neighbours[t]) {
        const std::uint32_t there = patch_of[other];
        if (there == patch) continue;
        if (into == kNone || std::pair(members[there].size(), there) < std::pair(members[into].size(), into))
          into = there;
      }
    if (into == kNone) continue;
    for (const std::uint32_t t : members[patch]) patch_of[t] = into;
    members[into].insert(members[into].end(), members[patch].begin(), members[patch].end());
    members[patch].clear();
  }

  PatchShapes shapes;
  shapes.patch_of.resize(count);
  shapes.first_sample.resize(count);
  for (std::vector<std::uint32_t>& triangles : members) {
    if (triangles.empty()) continue;
    std::sort(triangles.begin(), triangles.end());
    PatchShape shape;
    for (const std::uint32_t t : triangles) {
      shapes.patch_of[t] = static_cast<std::uint32_t>(shapes.patches.size());
      shapes.first_sample[t] = shape.samples;
      shape.first_sample.push_back(shape.samples);
      shape.samples += static_cast<std::uint32_t>(lattice_samples(rings.resolution(t)));
      shape.vertices.insert(shape.vertices.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    }
    std::sort(shape.vertices.begin(), shape.vertices.end());
    shape.vertices.erase(std::unique(shape.vertices.begin(), shape.vertices.end()), shape.vertices.end());
    shape.triangles = std::move(triangles);
    shapes.patches.push_back(std::move(shape));
  }
  return shapes;
}

}  // namespace sheen
