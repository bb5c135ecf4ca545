// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "common/geometry/mesh.h"

namespace sheen {

namespace {

constexpr double kWideOpen = 0.25;  ///< a box without its lid has 0.2

struct Edge {
  std::uint32_t low, high;
  bool upwards;  ///< the triangle runs from low to high
  bool operator<(const Edge& other) const { return std::pair(low, high) < std::pair(other.low, other.high); }
};

void count_edges(const Mesh& mesh, MeshDiagnosis& diagnosis) {
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t a = t[c], b = t[(c + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b});
    }
  std::sort(edges.begin(), edges.end());
  for (std::size_t first = 0, last = 0; first < edges.size(); first = last) {
    while (last < edges.size() && !(edges[first] < edges[last])) ++last;
    if (last - first == 1) ++diagnosis.boundary_edges;
    if (last - first > 2) ++diagnosis.non_manifold_edges;
    if (last - first == 2 && edges[first].upwards == edges[first + 1].upwards) ++diagnosis.inconsistent_edges;
  }
}

void count_components(const Mesh& mesh, MeshDiagnosis& diagnosis) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) used[v] = true;
    parent[root(t[1])] = root(t[0]);
    parent[root(t[2])] = root(t[0]);
  }
  for (std::uint32_t v = 0; v < parent.size(); ++v) {
    if (!used[v]) ++diagnosis.isolated_vertices;
    if (used[v] && parent[v] == v) ++diagnosis.components;
  }
}

/// The part of the surface that would close the mesh, seen from outside. The volume of one that is wide open, as things
/// on a table top are, depends on the point that it is counted from, and its sign says nothing.
double open_part(const Mesh& mesh) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d normal = mesh.area_normal(t).cast<double>();
    sum += normal;
    area += normal.norm();
  }
  return area > 0 ? sum.norm() / area : 0;
}

double signed_volume(const Mesh& mesh) {
  const Eigen::Vector3d centre = bounding_sphere(mesh).centre;  // keeps the sum small where a mesh is open or far off
  double six_volumes = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0).cast<double>() - centre, b = mesh.corner(t, 1).cast<double>() - centre,
                          c = mesh.corner(t, 2).cast<double>() - centre;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

}  // namespace

MeshDiagnosis diagnose(const Mesh& mesh) {
  MeshDiagnosis diagnosis;
  diagnosis.vertices = mesh.vertices.size();
  diagnosis.triangles = mesh.triangles.size();
  count_edges(mesh, diagnosis);
  count_components(mesh, diagnosis);
  if (open_part(mesh) < kWideOpen) diagnosis.signed_volume = signed_volume(mesh);
  return diagnosis;
}

std::vector<std::string> MeshDiagnosis::warnings() const {
  std::vector<std::string> out;
  const auto warn = [&](std::size_t count, const std::string& sentence) {
    if (count > 0) out.push_back(std::to_string(count) + " " + sentence);
  };
  warn(boundary_edges,
       "edges have a triangle on one side only (open sheet, hole or texture seam): surfaces seen from behind do not "
       "count; close the holes if the object has none, and weld vertices that coincide");
  warn(non_manifold_edges,
       "edges have three triangles or more: surfaces that touch or lie on each other share their colours there; split "
       "them in a mesh editor if this shows");
  warn(inconsistent_edges,
       "edges join triangles that face opposite ways: those that face inwards stay without colour; make the winding "
       "consistent");
  warn(isolated_vertices, "vertices belong to no triangle: they are ignored");
  warn(removed_degenerate, "faces had no area and were left out");
  warn(removed_duplicate, "triangles were listed twice; one of each was left out");
  if (components > 1)
    out.push_back("the mesh consists of " + std::to_string(components) +
                  " pieces: remove those that do not belong to the object, they would hide it");
  if (signed_volume < 0)
    out.push_back(
        "the mesh seems to be inside out (its volume is negative): flip its triangles if it stays uncoloured");
  return out;
}

}  // namespace sheen
