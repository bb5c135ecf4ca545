// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/light_field_file/mesh_coding.h"

namespace sheen {

/// A mesh in the order in which it is coded. A vertex of no triangle is not stored.
struct CodedMesh {
  GridMesh grid;                            ///< as a reader has it
  std::vector<std::uint32_t> old_vertex;    ///< for each vertex, its index before
  std::vector<std::uint32_t> old_triangle;  ///< for each triangle
  std::vector<std::uint8_t> first_corner;   ///< for each triangle: which corner it had there its corner 0 was
  std::string bytes;
};

/// The surface grows from one triangle over its open edges, vertex after vertex: for each edge it is coded whether a
/// triangle follows and which its third corner is, mostly one that the surface has beside the edge, or a new one. A new
/// vertex is coded by how it differs from the fourth corner of the parallelogram over the triangle before. Takes any
/// triangles, of surfaces or not. Points within 2^21 of 0.
CodedMesh encode_mesh(const GridMesh& mesh);

}  // namespace sheen
