// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace sheen {

using Triangle = std::array<std::uint32_t, 3>;  ///< vertex indices, counter-clockwise seen from outside

/// Triangle mesh in the object frame, metres.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Triangle> triangles;

  Eigen::Vector3f corner(std::size_t triangle, int c) const { return vertices[triangles[triangle][c]]; }
  /// Twice the area times the unit normal.
  Eigen::Vector3f area_normal(std::size_t triangle) const {
    return (corner(triangle, 1) - corner(triangle, 0)).cross(corner(triangle, 2) - corner(triangle, 0));
  }
};

struct BoundingSphere {
  Eigen::Vector3d centre;
  double radius = 0;
};
BoundingSphere bounding_sphere(const Mesh& mesh);  ///< of the bounding box

/// Area-weighted unit normal per vertex; +z where a vertex has no triangle.
std::vector<Eigen::Vector3f> vertex_normals(const Mesh& mesh);

/// What is wrong with a mesh. Meshes from the field have all of these; none stops a capture.
struct MeshDiagnosis {
  std::size_t vertices = 0, triangles = 0;
  std::size_t boundary_edges = 0;      ///< edges of one triangle: an open sheet or a hole
  std::size_t non_manifold_edges = 0;  ///< edges of three triangles or more
  std::size_t inconsistent_edges = 0;  ///< two triangles that run along the edge in the same direction
  std::size_t isolated_vertices = 0;
  std::size_t removed_degenerate = 0;  ///< triangles without area, dropped on loading
  std::size_t removed_duplicate = 0;   ///< triangles that are listed twice, dropped on loading
  std::size_t components = 0;
  double signed_volume = 0;                   ///< negative: probably inside out
  std::vector<std::string> warnings() const;  ///< a sentence each, with what to do; empty for a clean mesh
};

/// All but the two counts of what loading removed.
MeshDiagnosis diagnose(const Mesh& mesh);

struct LoadedMesh {
  Mesh mesh;
  MeshDiagnosis diagnosis;
};

/// Reads PLY (ASCII and binary, either byte order), OBJ or OFF. Polygons are split into fans. Throws FileError with the
/// line or element where a file is broken: out-of-range index, NaN, no triangle, truncated, unknown format.
LoadedMesh load_mesh(const std::filesystem::path& path);

/// The same files, validated but not cleaned: indices stay as they stand in the file.
Mesh load_mesh_unchanged(const std::filesystem::path& path);

/// Binary little-endian PLY of vertices and triangles. Throws FileError.
void save_ply(const Mesh& mesh, const std::filesystem::path& path);

}  // namespace sheen
