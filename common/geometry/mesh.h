// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace sheen {

using Triangle = std::array<std::uint32_t, 3>;  ///< vertex indices, counter-clockwise seen from outside

/// From what a vertex of a shape that was found in images is known.
enum class ShapeEvidence : std::uint8_t {
  kGuessed = 0,  ///< nothing shows it: the underside, or a place that no image sees
  kOutline = 1,  ///< outlines alone bound it
  kSeen = 2,     ///< two images or more agree about it
};

/// Triangle mesh in the object frame, metres.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;  ///< from `origin`
  std::vector<Triangle> triangles;
  /// In the frame of its file. Zero but for a mesh so far out (map coordinates) that single precision would not hold
  /// its shape: then the object frame is the file's with its origin here, and `in_frame_at` takes poses into it.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::vector<ShapeEvidence> evidence = {};  ///< per vertex, of a shape that was found in images; else empty

  Eigen::Vector3f corner(std::size_t triangle, int c) const { return vertices[triangles[triangle][c]]; }
  bool guessed_at(std::size_t vertex) const { return !evidence.empty() && evidence[vertex] == ShapeEvidence::kGuessed; }
  /// Twice the area times the unit normal.
  Eigen::Vector3f area_normal(std::size_t triangle) const {
    return (corner(triangle, 1) - corner(triangle, 0)).cross(corner(triangle, 2) - corner(triangle, 0));
  }
};

/// Decides the origin, by the vertices that triangles use: their coordinates' rounding in single precision is to be
/// less than 10^-5 of their extent.
Mesh mesh_of(std::span<const Eigen::Vector3d> vertices, std::vector<Triangle> triangles);
Mesh mesh_of(std::span<const Eigen::Vector3d> vertices, std::vector<Triangle> triangles, const Eigen::Vector3d& origin);
/// For what has a place of its own, such as a stage: throws FileError naming the mesh's file, and what to subtract from
/// its coordinates, where it has an origin.
void require_no_origin(const std::string& file, const Mesh& mesh);
/// The same mesh, its vertices told from another origin.
Mesh in_frame_at(const Eigen::Vector3d& origin, Mesh mesh);

struct BoundingSphere {
  Eigen::Vector3d centre;
  double radius = 0;
};
BoundingSphere bounding_sphere(const Mesh& mesh);  ///< of the bounding box

/// Of the vertices, those of which this is known; 0 of a mesh without evidence.
double share_known_as(ShapeEvidence evidence, const Mesh& mesh);

/// Area-weighted unit normal per vertex; +z where a vertex has no triangle.
std::vector<Eigen::Vector3f> vertex_normals(const Mesh& mesh);

/// What is wrong with a mesh. Meshes from the field have all of these; none stops a capture.
struct MeshDiagnosis {
  std::size_t vertices = 0, triangles = 0;
  std::size_t boundary_edges = 0;      ///< edges of one triangle: an open sheet or a hole
  std::size_t non_manifold_edges = 0;  ///< edges of three triangles or more
  std::size_t inconsistent_edges = 0;  ///< two triangles that run along the edge in the same direction
  std::size_t isolated_vertices = 0;   ///< of no triangle, dropped on loading
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

/// Reads PLY (ASCII and binary, either byte order), OBJ or OFF. Polygons, also concave ones, and PLY's triangle strips
/// become triangles; those without area or listed twice are dropped, and so are vertices of no triangle. Throws
/// FileError with the line or element where a file is broken: out-of-range index, NaN or a coordinate beyond
/// `kLongestLength`, no triangle, truncated, unknown format.
LoadedMesh load_mesh(const std::filesystem::path& path);

/// The same files, validated but not cleaned: indices stay as they stand in the file.
Mesh load_mesh_unchanged(const std::filesystem::path& path);

/// Binary little-endian PLY of vertices, with their evidence where they have one, and triangles, in the frame of the
/// mesh's file: in double precision where the mesh has an origin, which a comment keeps for when it is read again.
/// Throws FileError.
void save_ply(const Mesh& mesh, const std::filesystem::path& path);

}  // namespace sheen
