// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/patch_shapes.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "reconstructor/light_field_file/triangle_edges.h"

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

/// The columns of the vertices, and the patches round each.
void number_vertices(const Mesh& mesh, PatchShapes& shapes) {
  shapes.first_column.assign(1, 0);
  shapes.corner_column.resize(3 * mesh.triangles.size());
  shapes.first_round.assign(mesh.vertices.size() + 1, 0);
  for (const PatchShape& shape : shapes.patches) {
    for (const std::uint32_t t : shape.triangles)
      for (std::size_t c = 0; c < 3; ++c) {
        const auto at = std::lower_bound(shape.vertices.begin(), shape.vertices.end(), mesh.triangles[t][c]);
        shapes.corner_column[3 * std::size_t{t} + c] =
            shapes.first_column.back() + static_cast<std::uint32_t>(at - shape.vertices.begin());
      }
    shapes.first_column.push_back(shapes.first_column.back() + static_cast<std::uint32_t>(shape.vertices.size()));
    for (const std::uint32_t v : shape.vertices) ++shapes.first_round[v + 1];
  }
  std::partial_sum(shapes.first_round.begin(), shapes.first_round.end(), shapes.first_round.begin());
  shapes.patch_vertices.resize(shapes.columns());
  std::vector<std::uint32_t> next(shapes.first_round.begin(), shapes.first_round.end() - 1);
  for (std::uint32_t p = 0; p < shapes.patches.size(); ++p)
    for (std::uint32_t i = 0; i < shapes.patches[p].vertices.size(); ++i)
      shapes.patch_vertices[next[shapes.patches[p].vertices[i]]++] = {p, i};
}

}  // namespace

PatchShapes patch_shapes(const Mesh& mesh, const MapLayout& maps, std::vector<std::uint32_t> patch_of) {
  const auto last = std::max_element(patch_of.begin(), patch_of.end());
  const std::size_t patches = last == patch_of.end() ? 0 : *last + std::size_t{1};
  std::vector<std::size_t> next(patches + 1, 0);
  for (const std::uint32_t patch : patch_of) ++next[patch + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  const std::vector<std::size_t> first = next;
  auto members = std::make_shared<PatchMembers>();
  members->triangles.resize(patch_of.size());
  for (std::uint32_t t = 0; t < patch_of.size(); ++t) members->triangles[next[patch_of[t]]++] = t;

  PatchShapes shapes;
  std::vector<std::uint32_t> corners;
  std::vector<std::size_t> first_vertex{0};
  for (std::size_t p = 0; p < patches; ++p) {
    corners.clear();
    const auto triangles = std::span(members->triangles).subspan(first[p], first[p + 1] - first[p]);
    shapes.patches.push_back({.triangles = triangles});
    for (const std::uint32_t t : triangles)
      corners.insert(corners.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    members->vertices.insert(members->vertices.end(), corners.begin(), corners.end());
    first_vertex.push_back(members->vertices.size());
  }
  for (std::size_t p = 0; p < patches; ++p)
    shapes.patches[p].vertices =
        std::span(members->vertices).subspan(first_vertex[p], first_vertex[p + 1] - first_vertex[p]);
  shapes.members = std::move(members);
  shapes.patch_of = std::move(patch_of);
  shapes.first_sample.resize(mesh.triangles.size());
  number_vertices(mesh, shapes);
  return with_maps(std::move(shapes), maps);
}

PatchShapes with_maps(PatchShapes shapes, const MapLayout& maps) {
  for (PatchShape& shape : shapes.patches) {
    shape.samples = 0;
    for (const std::uint32_t t : shape.triangles) {
      shapes.first_sample[t] = shape.samples;
      shape.samples += static_cast<std::uint32_t>(lattice_samples(maps.resolution(t)));
    }
  }
  return shapes;
}

/// From triangle to triangle: a patch takes the free neighbour that has most corners in it already, the earliest of
/// equals. What is left over, less than a quarter of a patch, goes to the smallest patch beside it.
PatchShapes cut_into_patches(const Mesh& mesh, const MapLayout& maps, const PatchSize& size) {
  const auto neighbours = neighbours_of(mesh);
  const std::size_t count = mesh.triangles.size();
  std::vector<std::uint32_t> patch_of(count, kNone);
  std::vector<std::vector<std::uint32_t>> members;
  const auto samples_of = [&](const std::vector<std::uint32_t>& triangles) {
    std::size_t samples = 0;
    for (const std::uint32_t t : triangles) samples += static_cast<std::size_t>(lattice_samples(maps.resolution(t)));
    return samples;
  };
  for (std::uint32_t seed = 0; seed < count; ++seed) {
    if (patch_of[seed] != kNone) continue;
    const auto patch = static_cast<std::uint32_t>(members.size());
    std::vector<std::uint32_t> grown{seed};
    patch_of[seed] = patch;
    while (grown.size() < size.triangles || samples_of(grown) < size.samples) {
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
    if (4 * members[patch].size() > size.triangles && 4 * samples_of(members[patch]) >= size.samples) continue;
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

  std::uint32_t patches = 0;
  for (const std::vector<std::uint32_t>& triangles : members) {
    if (triangles.empty()) continue;
    for (const std::uint32_t t : triangles) patch_of[t] = patches;
    ++patches;
  }
  return patch_shapes(mesh, maps, std::move(patch_of));
}

}  // namespace sheen
