// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/mesh.h"

namespace sheen {

/// A mesh as its file has it, before it is cleaned.
struct RawMesh {
  std::vector<Eigen::Vector3d> vertices;  ///< in the frame of the file
  std::vector<Triangle> triangles;
  std::optional<Eigen::Vector3d> origin;     ///< that the file names, in place of one that `mesh_of` finds
  std::size_t empty_faces = 0;               ///< faces of fewer than three corners
  std::vector<ShapeEvidence> evidence = {};  ///< per vertex, or empty

  Mesh mesh() const {
    Mesh mesh = origin ? mesh_of(vertices, triangles, *origin) : mesh_of(vertices, triangles);
    mesh.evidence = evidence;
    return mesh;
  }
};

/// The three formats, from a file's bytes; `path` only names the file in errors. Throw FileError.
RawMesh read_ply(const std::string& path, std::string_view bytes);
RawMesh read_obj(const std::string& path, std::string_view bytes);
RawMesh read_off(const std::string& path, std::string_view bytes);

/// A number per vertex, which a PLY file can have beside the position.
struct VertexValues {
  std::string name;
  std::span<const float> values;
  bool bytes = false;  ///< written as whole numbers 0..255
};

/// As `save_ply` of mesh.h, with values of the vertices and a line of comment. Throws FileError.
void save_ply(const Mesh& mesh, const std::filesystem::path& path, std::span<const VertexValues> values,
              const std::string& comment = {});

/// Where in a file something stands: "line 12", "vertex 3".
struct FilePlace {
  const char* kind;
  std::size_t number;
};

/// Collects vertices and polygons and refuses what cannot be: the part that all formats share.
class MeshBuilder {
 public:
  explicit MeshBuilder(std::string path) : path_(std::move(path)) {}

  void add_vertex(double x, double y, double z, FilePlace place);
  /// Corners may refer to vertices that come later; `finish` checks that they came.
  void add_face(std::span<const double> corners, FilePlace place);
  /// Triangles of three corners in a row each, every other one turned; a negative corner ends a strip.
  void add_strips(std::span<const double> corners, FilePlace place);
  void set_origin(const Eigen::Vector3d& origin) { origin_ = origin; }
  std::size_t vertex_count() const { return vertices_.size(); }
  RawMesh finish();
  [[noreturn]] void fail(FilePlace place, const std::string& what) const;

 private:
  struct Polygon {
    FilePlace place;
    std::uint32_t size = 0;
  };
  std::vector<Triangle> triangles() const;

  std::string path_;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<std::uint32_t> corners_;  ///< of all polygons, one after the other
  std::vector<Polygon> polygons_;
  std::size_t empty_faces_ = 0;
  std::optional<Eigen::Vector3d> origin_;
  std::uint32_t largest_index_ = 0;
  FilePlace largest_place_{"face", 0};
};

/// Lines of a text file as words: comments from `#` on, carriage returns and (where `continuations`) line ends behind a
/// backslash are taken away. Counts lines from 1.
class WordReader {
 public:
  WordReader(std::string_view text, bool continuations);
  /// The words of the next line that has any; false at the end.
  bool next(std::vector<std::string_view>& words);
  FilePlace place() const { return {"line", first_line_}; }

 private:
  std::string_view rest_;
  bool continuations_;
  std::size_t line_ = 0;
  std::size_t first_line_ = 0;
};

/// A number, the whole of the word. Independent of the locale.
std::optional<double> parse_number(std::string_view word);

}  // namespace sheen
