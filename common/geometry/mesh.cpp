// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/geometry/mesh_io.h"

namespace sheen {

namespace {

/// Twice the area below which a triangle has none, in squares of its longest edge.
constexpr double kNoArea = 1e-9;

RawMesh read_mesh(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  const std::string_view start = std::string_view(bytes).substr(0, 8);
  if (start.starts_with("ply")) return read_ply(path.string(), bytes);
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (extension == ".off" || start.starts_with("OFF")) return read_off(path.string(), bytes);
  if (extension == ".obj") return read_obj(path.string(), bytes);
  throw FileError(path.string(), bytes.empty() ? "is empty"
                                               : "is neither PLY nor OBJ nor OFF; export it as one of these from the "
                                                 "program that made it");
}

template <typename Vertices>
bool has_area(const Vertices& vertices, const Triangle& triangle) {
  const Eigen::Vector3d a = vertices[triangle[0]].template cast<double>(),
                        b = vertices[triangle[1]].template cast<double>(),
                        c = vertices[triangle[2]].template cast<double>();
  const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return (b - a).cross(c - a).norm() > kNoArea * longest;
}

/// The same corners in the same order round, from the smallest index on.
Triangle rotated_to_smallest(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

template <typename Vertices>
std::size_t remove_degenerate(const Vertices& vertices, std::vector<Triangle>& triangles) {
  return std::erase_if(triangles, [&](const Triangle& t) { return !has_area(vertices, t); });
}

/// Without what has no area, in the file's own precision and in single precision from the origin. The triangles that
/// stay decide the origin: one that goes may lie where coordinates begin, far from all others.
Mesh mesh_with_area(RawMesh& raw) {
  remove_degenerate(raw.vertices, raw.triangles);
  while (true) {
    Mesh mesh = raw.mesh();
    if (remove_degenerate(mesh.vertices, mesh.triangles) == 0) return mesh;
    raw.triangles = std::move(mesh.triangles);
  }
}

/// Keeps the first of equal triangles. The two sides of a sheet are not equal.
std::size_t remove_duplicates(Mesh& mesh) {
  std::vector<std::size_t> order(mesh.triangles.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::vector<Triangle> key(mesh.triangles.size());
  std::transform(mesh.triangles.begin(), mesh.triangles.end(), key.begin(), rotated_to_smallest);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key[a] < key[b]; });
  std::vector<bool> drop(key.size(), false);
  for (std::size_t i = 1; i < order.size(); ++i) drop[order[i]] = key[order[i]] == key[order[i - 1]];
  std::size_t kept = 0;
  for (std::size_t t = 0; t < key.size(); ++t)
    if (!drop[t]) mesh.triangles[kept++] = mesh.triangles[t];
  const std::size_t removed = mesh.triangles.size() - kept;
  mesh.triangles.resize(kept);
  return removed;
}

/// Of no triangle: a stray one would say how large the object is, and where.
std::size_t remove_isolated(Mesh& mesh) {
  constexpr std::uint32_t kNone = UINT32_MAX;
  std::vector<std::uint32_t> now(mesh.vertices.size(), kNone);
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) now[v] = 0;
  std::uint32_t kept = 0;
  for (std::size_t v = 0; v < now.size(); ++v) {
    if (now[v] == kNone) continue;
    mesh.vertices[kept] = mesh.vertices[v];
    if (!mesh.evidence.empty()) mesh.evidence[kept] = mesh.evidence[v];
    now[v] = kept++;
  }
  for (Triangle& triangle : mesh.triangles)
    for (std::uint32_t& v : triangle) v = now[v];
  const std::size_t removed = mesh.vertices.size() - kept;
  mesh.vertices.resize(kept);
  if (!mesh.evidence.empty()) mesh.evidence.resize(kept);
  return removed;
}

}  // namespace

Mesh mesh_of(std::span<const Eigen::Vector3d> vertices, std::vector<Triangle> triangles) {
  constexpr double kFarthest = 64;  // in radii: a radius has 2^17 steps there
  Eigen::AlignedBox3d box;
  for (const Triangle& triangle : triangles)
    for (const std::uint32_t v : triangle) box.extend(vertices[v]);
  const double radius = box.isEmpty() ? 0 : box.diagonal().norm() / 2;
  if (!(radius > 0 && box.center().cwiseAbs().maxCoeff() > kFarthest * radius))
    return mesh_of(vertices, std::move(triangles), Eigen::Vector3d::Zero());
  // On a coarse grid, so that coordinates told from it are exact and a person can read it.
  const double grid = std::exp2(std::floor(std::log2(radius)));
  return mesh_of(vertices, std::move(triangles), grid * (box.center() / grid).array().round());
}

Mesh mesh_of(std::span<const Eigen::Vector3d> vertices, std::vector<Triangle> triangles,
             const Eigen::Vector3d& origin) {
  Mesh mesh{.vertices = {}, .triangles = std::move(triangles), .origin = origin};
  mesh.vertices.reserve(vertices.size());
  for (const Eigen::Vector3d& vertex : vertices) mesh.vertices.push_back((vertex - origin).cast<float>());
  return mesh;
}

void require_no_origin(const std::string& file, const Mesh& mesh) {
  if (mesh.origin.isZero(0)) return;
  throw FileError(file, format("lies %.4g km from the origin of its coordinates, which are a map's, not a stage's: "
                               "subtract (%.12g, %.12g, %.12g) from them",
                               mesh.origin.norm() / 1e3, mesh.origin.x(), mesh.origin.y(), mesh.origin.z()));
}

Mesh in_frame_at(const Eigen::Vector3d& origin, Mesh mesh) {
  if (origin == mesh.origin) return mesh;
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex = (vertex.cast<double>() + (mesh.origin - origin)).cast<float>();
  mesh.origin = origin;
  return mesh;
}

double share_known_as(ShapeEvidence evidence, const Mesh& mesh) {
  const auto known = std::count(mesh.evidence.begin(), mesh.evidence.end(), evidence);
  return mesh.evidence.empty() ? 0 : static_cast<double>(known) / static_cast<double>(mesh.evidence.size());
}

LoadedMesh load_mesh(const std::filesystem::path& path) {
  RawMesh raw = read_mesh(path);
  const std::size_t all = raw.triangles.size();
  LoadedMesh loaded{.mesh = mesh_with_area(raw), .diagnosis = {}};
  const std::size_t degenerate = raw.empty_faces + all - loaded.mesh.triangles.size();
  const std::size_t duplicate = remove_duplicates(loaded.mesh);
  if (loaded.mesh.triangles.empty()) throw FileError(path.string(), "none of its triangles has an area");
  const std::size_t isolated = remove_isolated(loaded.mesh);
  loaded.diagnosis = diagnose(loaded.mesh);
  loaded.diagnosis.isolated_vertices = isolated;
  loaded.diagnosis.removed_degenerate = degenerate;
  loaded.diagnosis.removed_duplicate = duplicate;
  return loaded;
}

Mesh load_mesh_unchanged(const std::filesystem::path& path) {
  return read_mesh(path).mesh();
}

}  // namespace sheen
