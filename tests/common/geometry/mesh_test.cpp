// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temp_folder.h"

namespace sheen {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

Mesh tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

TEST(BoundingSphere, OfTheBox) {
  const BoundingSphere sphere = bounding_sphere({{{-1, 0, 2}, {3, 4, 4}}, {}});
  EXPECT_EQ(sphere.centre, Eigen::Vector3d(1, 2, 3));
  EXPECT_DOUBLE_EQ(sphere.radius, 3);
  EXPECT_EQ(bounding_sphere({}).radius, 0);
}

TEST(VertexNormals, AreWeightedByArea) {
  // Two triangles round vertex 0: one of area 2 that faces +z, one of area 1/2 that faces +x.
  const Mesh mesh{{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 1, 0}, {0, 0, 1}, {9, 9, 9}}, {{0, 1, 2}, {0, 3, 4}}};
  const auto normals = vertex_normals(mesh);
  EXPECT_LT((normals[0] - Eigen::Vector3f(1, 0, 4).normalized()).norm(), 1e-6f);
  EXPECT_LT((normals[1] - Eigen::Vector3f(0, 0, 1)).norm(), 1e-6f);
  EXPECT_LT((normals[3] - Eigen::Vector3f(1, 0, 0)).norm(), 1e-6f);
  EXPECT_EQ(normals[5], Eigen::Vector3f(0, 0, 1)) << "belongs to no triangle";
}

TEST(VertexNormals, OfAVeryLargeAndAVerySmallMesh) {
  for (const float scale : {1e-10f, 1e10f}) {
    Mesh mesh = tetrahedron();
    for (auto& v : mesh.vertices) v *= scale;
    const auto normals = vertex_normals(mesh);
    EXPECT_LT((normals[0] + Eigen::Vector3f(1, 1, 1).normalized()).norm(), 1e-5f) << scale;
  }
}

TEST(MeshDiagnosis, NothingToSayOfACleanMesh) {
  const MeshDiagnosis d = diagnose(tetrahedron());
  EXPECT_EQ(d.vertices, 4u);
  EXPECT_EQ(d.triangles, 4u);
  EXPECT_EQ(d.boundary_edges + d.non_manifold_edges + d.inconsistent_edges + d.isolated_vertices, 0u);
  EXPECT_EQ(d.components, 1u);
  EXPECT_NEAR(d.signed_volume, 1.0 / 6, 1e-12);
  EXPECT_THAT(d.warnings(), ElementsAre());
}

TEST(MeshDiagnosis, CountsWhatIsWrong) {
  Mesh open = tetrahedron();
  open.triangles.pop_back();
  EXPECT_EQ(diagnose(open).boundary_edges, 3u);
  EXPECT_THAT(diagnose(open).warnings(), ElementsAre(HasSubstr("3 edges have a triangle on one side only")));

  // A table top with nothing below it, and a thing that stands on it.
  Mesh still_life = tetrahedron();
  still_life.vertices.insert(still_life.vertices.end(), {{-9, -9, -3}, {9, -9, -3}, {0, 9, -3}});
  still_life.triangles.push_back({4, 5, 6});
  for (const std::string& warning : diagnose(still_life).warnings())
    EXPECT_THAT(warning, ::testing::Not(HasSubstr("inside out")));

  Mesh inside_out = tetrahedron();
  for (Triangle& t : inside_out.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(diagnose(inside_out).signed_volume, -1.0 / 6, 1e-12);
  EXPECT_THAT(diagnose(inside_out).warnings(), ElementsAre(HasSubstr("inside out")));

  Mesh one_flipped = tetrahedron();
  std::swap(one_flipped.triangles[2][0], one_flipped.triangles[2][1]);
  EXPECT_EQ(diagnose(one_flipped).inconsistent_edges, 3u);

  Mesh fin = tetrahedron();  // a fifth triangle on the edge 0-1
  fin.vertices.push_back({0.5f, -1, -1});
  fin.triangles.push_back({0, 1, 4});
  EXPECT_EQ(diagnose(fin).non_manifold_edges, 1u);
  EXPECT_EQ(diagnose(fin).boundary_edges, 2u);

  Mesh two = tetrahedron();
  for (const auto& v : tetrahedron().vertices) two.vertices.push_back(v + Eigen::Vector3f(5, 0, 0));
  for (const Triangle& t : tetrahedron().triangles) two.triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
  two.vertices.push_back({0, 0, 9});
  EXPECT_EQ(diagnose(two).components, 2u);
  EXPECT_EQ(diagnose(two).isolated_vertices, 1u);
  EXPECT_THAT(diagnose(two).warnings(), Contains(HasSubstr("2 pieces")));
}

TEST(MeshDiagnosis, VolumeFarFromTheOriginIsExactEnough) {
  Mesh mesh = tetrahedron();
  for (auto& v : mesh.vertices) v += Eigen::Vector3f(4096, -2048, 1024);
  EXPECT_NEAR(diagnose(mesh).signed_volume, 1.0 / 6, 1e-9);
}

TEST(LoadMesh, DropsDegenerateAndDuplicateTrianglesAndKeepsTheOrder) {
  const TempFolder folder;
  const LoadedMesh loaded = load_mesh(folder.write("a.obj",
                                                   "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 2 0 0\n"
                                                   "f 1 3 2\n"
                                                   "f 1 1 2\n"     // two corners in one
                                                   "f 1 2 5\n"     // all on a line
                                                   "f 1 2 4\n"     //
                                                   "f 3 2 1\n"     // the first again, begun elsewhere
                                                   "f 1 2\n"       // no polygon
                                                   "f 1 2 3\n"));  // the first from behind: another surface
  EXPECT_THAT(loaded.mesh.triangles, ElementsAre(Triangle{0, 2, 1}, Triangle{0, 1, 3}, Triangle{0, 1, 2}));
  EXPECT_EQ(loaded.diagnosis.removed_degenerate, 3u);
  EXPECT_EQ(loaded.diagnosis.removed_duplicate, 1u);
  EXPECT_THAT(loaded.diagnosis.warnings(), Contains(HasSubstr("3 faces had no area")));
}

TEST(LoadMesh, AStrayVertexSaysNothingOfTheObject) {
  const TempFolder folder;
  const LoadedMesh loaded = load_mesh(
      folder.write("a.obj", "v 1e8 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 2 4 3\nf 2 3 5\nf 2 5 4\nf 3 4 5\n"));
  EXPECT_THAT(loaded.mesh.triangles,
              ElementsAre(Triangle{0, 2, 1}, Triangle{0, 1, 3}, Triangle{0, 3, 2}, Triangle{1, 2, 3}));
  EXPECT_LT(bounding_sphere(loaded.mesh).radius, 1);
  EXPECT_NEAR(loaded.diagnosis.signed_volume, 1.0 / 6, 1e-12);
  EXPECT_THAT(loaded.diagnosis.warnings(), ElementsAre(HasSubstr("1 vertices belong to no triangle")));
}

TEST(LoadMesh, KeepsTinyButSoundTriangles) {
  const TempFolder folder;
  const LoadedMesh loaded = load_mesh(folder.write("a.obj", "v 0 0 0\nv 1e-9 0 0\nv 0 1e-9 0\nf 1 2 3\n"));
  EXPECT_EQ(loaded.mesh.triangles.size(), 1u);
}

}  // namespace
}  // namespace sheen
