// SPDX-License-Identifier: Apache-2.0
// Whatever a PLY, OBJ or OFF file holds: a mesh with finite vertices and no index beyond them, which is the same
// through any of the three formats and stays as it is when it is cleaned again; or a FileError.
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/geometry/mesh.h"
#include "common/geometry/mesh_io.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/support/temp_folder.h"

namespace {

using namespace sheen;
using fuzz::demand;
using fuzz::Input;

void expect_sound(const Mesh& mesh) {
  for (const Eigen::Vector3f& vertex : mesh.vertices) demand(vertex.allFinite(), "a vertex is not finite");
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) demand(corner < mesh.vertices.size(), "an index beyond the vertices");
}

void expect_same(const Mesh& a, const Mesh& b) {
  demand(a.vertices == b.vertices && a.triangles == b.triangles, "another mesh through another format");
}

/// As text of either format: OBJ counts from 1, OFF has the counts before it.
std::string as_text(const Mesh& mesh, bool obj) {
  std::string text =
      obj ? "" : "OFF " + std::to_string(mesh.vertices.size()) + " " + std::to_string(mesh.triangles.size()) + " 0\n";
  char line[100];
  for (const Eigen::Vector3f& v : mesh.vertices) {
    std::snprintf(line, sizeof line, "%s%.9g %.9g %.9g\n", obj ? "v " : "", v[0], v[1], v[2]);
    text += line;
  }
  for (const Triangle& t : mesh.triangles) {
    std::snprintf(line, sizeof line, "%s%u %u %u\n", obj ? "f " : "3 ", t[0] + obj, t[1] + obj, t[2] + obj);
    text += line;
  }
  return text;
}

void expect_cleaned_once(const std::filesystem::path& file) {
  const LoadedMesh cleaned = load_mesh(file);
  expect_sound(cleaned.mesh);
  save_ply(cleaned.mesh, file);
  const LoadedMesh again = load_mesh(file);
  expect_same(cleaned.mesh, again.mesh);
  demand(again.diagnosis.removed_degenerate == 0 && again.diagnosis.removed_duplicate == 0, "not clean when cleaned");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TempFolder folder;
  constexpr RawMesh (*kReaders[])(const std::string&, std::string_view) = {read_ply, read_obj, read_off};
  Input in{{data, size}};
  const auto read = kReaders[in.byte() % 3];
  try {
    const Mesh mesh = read("fuzz", in.text()).mesh();
    expect_sound(mesh);
    if (mesh.origin.isZero(0)) {
      expect_same(mesh, read_obj("fuzz.obj", as_text(mesh, true)).mesh());
      expect_same(mesh, read_off("fuzz.off", as_text(mesh, false)).mesh());
    }
    const auto file = folder.path() / "mesh.ply";
    save_ply(mesh, file);
    expect_same(mesh, load_mesh_unchanged(file));
    expect_cleaned_once(file);
  } catch (const FileError&) {
  }
  return 0;
}
