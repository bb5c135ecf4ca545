// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "common/base/files.h"
#include "common/base/format.h"
#include "common/geometry/mesh.h"
#include "common/geometry/mesh_io.h"
#include "support/temp_folder.h"

namespace sheen {
namespace {

/// Corners of a sheet of 80 x 50 mm.
const std::vector<Eigen::Vector3d> kSheet = {{0, 0, 0.5}, {0.08, 0, 0.5}, {0.08, 0.05, 0.5}, {0, 0.05, 0.5}};
const std::vector<Triangle> kTriangles = {{0, 1, 2}, {0, 2, 3}};
const Eigen::Vector3d kUtm(500'123.4, 4'649'776.5, 312.75);

std::vector<Eigen::Vector3d> moved(const Eigen::Vector3d& by) {
  std::vector<Eigen::Vector3d> vertices;
  for (const Eigen::Vector3d& vertex : kSheet) vertices.push_back(vertex + by);
  return vertices;
}

/// To the rounding of doubles so far out.
void expect_in_place(const Mesh& mesh, const Eigen::Vector3d& by) {
  ASSERT_EQ(mesh.vertices.size(), kSheet.size());
  EXPECT_EQ(mesh.triangles, kTriangles);
  for (std::size_t v = 0; v < kSheet.size(); ++v)
    EXPECT_LT((mesh.vertices[v].cast<double>() + mesh.origin - by - kSheet[v]).norm(), 1e-7);
}

TEST(MeshOrigin, AMeshThatSinglePrecisionHoldsHasNone) {
  const Mesh mesh = mesh_of(moved({1, -2, 0.25}), kTriangles);
  EXPECT_EQ(mesh.origin, Eigen::Vector3d::Zero());
  expect_in_place(mesh, {1, -2, 0.25});
}

TEST(MeshOrigin, MapCoordinatesKeepTheirShape) {
  const Mesh mesh = mesh_of(moved(kUtm), kTriangles);
  EXPECT_LT((mesh.origin - kUtm).norm(), 1);
  expect_in_place(mesh, kUtm);
}

TEST(MeshOrigin, IsFoundByWhatTrianglesUse) {
  std::vector<Eigen::Vector3d> vertices = moved(kUtm);
  vertices.emplace_back(0, 0, 0);  // as exporters leave it behind
  EXPECT_LT((mesh_of(vertices, kTriangles).origin - kUtm).norm(), 1);
}

TEST(MeshOrigin, IsFoundByTrianglesThatHaveAnArea) {
  const TempFolder folder;
  std::string text;
  for (const Eigen::Vector3d& v : moved(kUtm)) text += format("v %.10f %.10f %.10f\n", v.x(), v.y(), v.z());
  text += "v 0 0 0\nf 1 2 3\nf 1 3 4\nf 1 5 5\nf 5 5 5\n";  // a face that a program left where it begins to count
  const LoadedMesh loaded = load_mesh(folder.write("a.obj", text));
  EXPECT_LT((loaded.mesh.origin - kUtm).norm(), 1);
  expect_in_place(loaded.mesh, kUtm);
  EXPECT_EQ(loaded.diagnosis.removed_degenerate, 2);
}

TEST(MeshOrigin, IsFoundByWhatIsLeftInSinglePrecision) {
  // The second triangle vanishes in the steps of single precision; the first, alone, is far out.
  const TempFolder folder;
  const LoadedMesh loaded = load_mesh(folder.write("a.obj",
                                                   "v 20000 0 0\nv 20001 0 0\nv 20000 1 0\nf 1 2 3\n"
                                                   "v 9999 0 0\nv 9999.00001 0 0\nv 9999 0.00001 0\nf 4 5 6\n"));
  EXPECT_EQ(loaded.diagnosis.removed_degenerate, 1);
  EXPECT_GT(loaded.mesh.origin.norm(), 19'000);
  save_ply(loaded.mesh, folder.path() / "a.ply");
  EXPECT_EQ(load_mesh(folder.path() / "a.ply").mesh.vertices, loaded.mesh.vertices);
}

TEST(MeshOrigin, EveryFormatIsReadInDoublePrecision) {
  const TempFolder folder;
  std::string places, obj;
  for (const Eigen::Vector3d& v : moved(kUtm)) {
    const std::string place = format("%.10f %.10f %.10f\n", v.x(), v.y(), v.z());
    places += place;
    obj += "v " + place;
  }
  const std::string faces = "3 0 1 2\n3 0 2 3\n";
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
      "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
  expect_in_place(load_mesh(folder.write("a.ply", head + places + faces)).mesh, kUtm);
  expect_in_place(load_mesh(folder.write("a.off", "OFF\n4 2 0\n" + places + faces)).mesh, kUtm);
  expect_in_place(load_mesh(folder.write("a.obj", obj + "f 1 2 3\nf 1 3 4\n")).mesh, kUtm);
}

TEST(MeshOrigin, WhatIsSavedStandsInTheFilesFrameAndIsReadBackToTheBit) {
  const TempFolder folder;
  Mesh mesh = mesh_of(moved(kUtm), kTriangles);
  save_ply(mesh, folder.path() / "far.ply");
  Mesh again = load_mesh_unchanged(folder.path() / "far.ply");
  EXPECT_EQ(again.vertices, mesh.vertices);
  EXPECT_EQ(again.origin, mesh.origin);
  // Of a part of it, too, which alone would have another origin; with values of the vertices.
  mesh.triangles.pop_back();
  const std::vector<float> heights(mesh.vertices.size(), 7);
  const VertexValues values[] = {{"height", heights}};
  save_ply(mesh, folder.path() / "part.ply", values);
  again = load_mesh_unchanged(folder.path() / "part.ply");
  EXPECT_EQ(again.vertices, mesh.vertices);
  EXPECT_EQ(again.origin, mesh.origin);
  // What does not know the comment finds the coordinates of the file.
  std::string text = read_file(folder.path() / "far.ply");
  text.replace(text.find("sheen_origin"), 12, "other_origin");
  expect_in_place(load_mesh_unchanged(folder.write("other.ply", text)), kUtm);
}

TEST(MeshOrigin, CanBeMoved) {
  const Mesh mesh = in_frame_at(kUtm + Eigen::Vector3d(0.25, 0, -0.5), mesh_of(moved(kUtm), kTriangles));
  EXPECT_EQ(mesh.origin, kUtm + Eigen::Vector3d(0.25, 0, -0.5));
  for (std::size_t v = 0; v < kSheet.size(); ++v)
    EXPECT_LT((mesh.vertices[v].cast<double>() + mesh.origin - kUtm - kSheet[v]).norm(), 1e-7);
}

}  // namespace
}  // namespace sheen
