// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>

#include "common/base/files.h"
#include "common/geometry/mesh.h"
#include "support/expect_error.h"
#include "support/shared_data.h"
#include "support/temp_folder.h"

namespace sheen {
namespace {

/// A pyramid over the unit square: 5 vertices; base quad and 4 triangles, outwards.
const std::vector<Eigen::Vector3f> kPyramid = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1.25}};
const std::vector<Triangle> kPyramidTriangles = {{3, 2, 1}, {3, 1, 0}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};

void expect_pyramid(const LoadedMesh& loaded) {
  EXPECT_EQ(loaded.mesh.vertices, kPyramid);
  EXPECT_EQ(loaded.mesh.triangles, kPyramidTriangles);
  EXPECT_THAT(loaded.diagnosis.warnings(), testing::IsEmpty());
  EXPECT_NEAR(loaded.diagnosis.signed_volume, 1.25 / 3, 1e-9);
}

template <typename T>
void append(std::string& out, T value, bool big_endian) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  if (big_endian) std::reverse(bytes, bytes + sizeof(T));
  out.append(bytes, sizeof(T));
}

/// Doubles, extra properties of every kind before, between and behind, an element between and one behind.
std::string pyramid_ply(bool big_endian) {
  std::string out =
      std::string("ply\nformat ") + (big_endian ? "binary_big_endian" : "binary_little_endian") +
      " 1.0\ncomment made by hand\nobj_info nothing\nelement vertex 5\nproperty uchar flag\n"
      "property double x\nproperty double y\nproperty short spare\nproperty double z\nproperty list uchar "
      "float weights\nelement material 2\nproperty int8 kind\nelement face 5\nproperty float quality\n"
      "property list ushort uint32 vertex_index\nproperty list uchar float texcoord\nelement edge 1\n"
      "property int vertex1\nproperty int vertex2\nend_header\n";
  const auto put = [&](auto value) { append(out, value, big_endian); };
  for (const Eigen::Vector3f& v : kPyramid) {
    put(std::uint8_t(7));
    put(double(v.x()));
    put(double(v.y()));
    put(std::int16_t(-3));
    put(double(v.z()));
    put(std::uint8_t(2));
    put(0.5f);
    put(0.25f);
  }
  put(std::int8_t(1));
  put(std::int8_t(-1));
  const std::vector<std::vector<std::uint32_t>> faces = {{3, 2, 1, 0}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  for (const auto& face : faces) {
    put(1.5f);
    put(std::uint16_t(face.size()));
    for (const std::uint32_t corner : face) put(corner);
    put(std::uint8_t(1));
    put(9.f);
  }
  put(std::int32_t(0));
  put(std::int32_t(1));
  return out;
}

const char* const kAsciiPly =
    "ply\r\nformat ascii 1.0\r\nelement vertex 5\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n"
    "element face 5\r\nproperty list uchar int vertex_indices\r\nend_header\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n"
    "+.5 5e-1 1.25\r\n4 3 2 1 0\r\n3 0 1 4\r\n3 1 2 4\r\n3 2 3 4\r\n3 3 0 4\r\n";

TEST(Ply, BinaryOfBothByteOrdersWithAnyPropertiesAndElements) {
  const TempFolder folder;
  for (const bool big_endian : {false, true}) expect_pyramid(load_mesh(folder.write("a.ply", pyramid_ply(big_endian))));
}

TEST(Ply, AsciiWithCarriageReturns) {
  const TempFolder folder;
  expect_pyramid(load_mesh(folder.write("a.ply", kAsciiPly)));
}

TEST(Ply, FacesMayStandBeforeVertices) {
  const TempFolder folder;
  expect_pyramid(load_mesh(folder.write(
      "a.ply",
      "ply\nformat ascii 1.0\nelement face 5\nproperty list uchar int vertex_indices\nelement vertex 5\nproperty float "
      "x\nproperty float y\nproperty float z\nend_header\n4 3 2 1 0\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n0 0 0\n1 0 0\n"
      "1 1 0\n0 1 0\n.5 .5 1.25\n")));
}

TEST(Ply, CutOffAnywhereIsAnErrorAndNothingElse) {
  const TempFolder folder;
  const std::string whole = pyramid_ply(false);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THROW(load_mesh(folder.write("a.ply", whole.substr(0, size))), FileError) << size;
}

TEST(Ply, EveryDamagedByteIsReadOrRefused) {
  const TempFolder folder;
  const std::string whole = pyramid_ply(true);
  int refused = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x91);
    try {
      load_mesh(folder.write("a.ply", damaged));
    } catch (const FileError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 300) << "at least what is in the header";
}

TEST(Ply, ClaimedSizesAreNotBelieved) {
  const TempFolder folder;
  const std::string head = "ply\nformat binary_little_endian 1.0\n";
  const std::string vertex = "property float x\nproperty float y\nproperty float z\n";
  expect_error([&] { load_mesh(folder.write("a.ply", head + "element vertex 1e18\n" + vertex + "end_header\nabc")); },
               {"a.ply", "vertex 0", "cut off"});
  expect_error(
      [&] {
        load_mesh(folder.write(
            "a.ply", head + "element face 1\nproperty list uint int vertex_indices\nend_header\n\xff\xff\xff\x7f"));
      },
      {"a.ply", "face 0", "cut off"});
  expect_error([&] { load_mesh(folder.write("a.ply", head + "element nothing 1e18\nend_header\n")); },
               {"nothing", "no property"});
}

TEST(Ply, SaysWhatIsWrong) {
  const TempFolder folder;
  const auto refused = [&](std::string text, const std::string& from, const std::string& to,
                           const std::vector<std::string>& words) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos);
    text.replace(at, from.size(), to);
    expect_error([&] { load_mesh(folder.write("a.ply", text)); }, words);
  };
  refused(kAsciiPly, "3 0 1 4", "3 0 1 5", {"a.ply", "face 1", "vertex 5", "there are 5"});
  refused(kAsciiPly, "3 0 1 4", "3 0 -1 4", {"face 1", "not a vertex index"});
  refused(kAsciiPly, "3 0 1 4", "3 0 1.5 4", {"face 1", "not a vertex index"});
  refused(kAsciiPly, "1 1 0", "1 nan 0", {"vertex 2", "not a finite number"});
  refused(kAsciiPly, "1 1 0", "1 1e300 0", {"vertex 2", "not a finite number"});
  refused(kAsciiPly, "1 1 0", "1 one 0", {"vertex 2", "property y"});
  refused(kAsciiPly, "property float z", "property float w", {"x, y, z"});
  refused(kAsciiPly, "property float z", "property real z", {"line 6", "real"});
  refused(kAsciiPly, "ascii", "morse", {"line 2", "format"});
  refused(kAsciiPly, "list uchar int vertex_indices", "list uchar int corners", {"no triangle"});
}

TEST(Obj, EveryFormOfFace) {
  const TempFolder folder;
  expect_pyramid(load_mesh(folder.write("a.OBJ",
                                        "\xEF\xBB\xBF# a comment\r\nmtllib some.mtl\r\no pyramid\r\nv 0 0 0\r\nv 1 0 0 "
                                        "1.0\r\nv 1 1 0 0.5 0.5 0.5\r\nv 0 1 \\\r\n 0 # behind\r\nv .5 .5 1.25\r\n"
                                        "vt 0 0\r\nvn 0 0 1\r\ng base\r\nusemtl stone\r\ns off\r\nf 4 3 2 1\r\n"
                                        "f 1/1 2/1 5/1\r\nf 2//1 3//1 5//1\r\nf 3/1/1 4/1/1 \\\r\n  5/1/1\r\n"
                                        "f -2 -5 -1\r\nl 1 2\r\n")));
}

TEST(Obj, SaysWhatIsWrong) {
  const TempFolder folder;
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    expect_error([&] { load_mesh(folder.write("a.obj", text)); }, words);
  };
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  refused(three + "\n\nf 1 2 4\n", {"a.obj", "line 6", "vertex 3", "there are 3"});
  refused(three + "f 1 2 -4\n", {"line 4", "before the first"});
  refused(three + "f 1 2 0\n", {"line 4", "\"0\""});
  refused(three + "f 1 2 x/1\n", {"line 4", "x/1"});
  refused(three + "f 1 2 99999999999999999999\n", {"line 4"});
  refused(three + "f 1 2 3.5\n", {"line 4"});
  refused("v 0 0\n", {"line 1", "three numbers"});
  refused("v 0 0 inf\n" + three, {"line 1", "finite"});
  refused(three, {"no triangle"});
  refused(three + "f 1 2\n", {"no triangle"});
  refused(three + "f 1 1 2\n", {"area"});
  refused("", {"no vertex"});
  refused(std::string("\0\xff\xfe\x80garbage\n\\", 13), {"no vertex"});
}

TEST(Off, CountsOnTheFirstLineOrTheNextAndColours) {
  const TempFolder folder;
  const std::string body =
      "0 0 0\n1 0 0 # a corner\n\n1 1 0\n0 1 0\n.5 .5 1.25\n4 3 2 1 0 255 0 0\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n";
  expect_pyramid(load_mesh(folder.write("a.off", "OFF\n# comment\n5 5 0\n" + body)));
  expect_pyramid(load_mesh(folder.write("a.off", "OFF 5 5 0\n" + body)));
  expect_pyramid(load_mesh(folder.write("a.off", "5 5 0\n" + body)));
  expect_pyramid(load_mesh(folder.write("without_extension", "OFF\n5 5 0\n" + body)));
  const std::string coloured =
      "COFF\n5 5 0\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n1 1 0 1 1 1 1\n0 1 0 1 1 1 1\n.5 .5 1.25 1 1 1 1\n4 3 2 1 0\n3 0 1 "
      "4\n"
      "3 1 2 4\n3 2 3 4\n3 3 0 4\n";
  expect_pyramid(load_mesh(folder.write("a.off", coloured)));
}

TEST(Off, SaysWhatIsWrong) {
  const TempFolder folder;
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    expect_error([&] { load_mesh(folder.write("a.off", text)); }, words);
  };
  refused("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", {"a.off", "line 6", "face"});
  refused("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", {"line 6", "vertex 3"});
  refused("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n", {"ends", "face"});
  refused("OFF\n1e18 1e18 0\n0 0 0\n", {"ends", "vertex"});
  refused("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n1e18 0 1 2\n", {"line 6"});
  refused("4OFF\n3 1 0\n", {"line 1", "variant"});
  refused("OFF BINARY\n", {"line 1", "variant"});
  refused("OFF\n", {"ends", "counts"});
}

TEST(Off, CountsThatAreWrittenAgainstTheWord) {
  const TempFolder folder;
  const std::string body = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n.5 .5 1.25\n4 3 2 1 0\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n";
  expect_pyramid(load_mesh(folder.write("a.off", "OFF5 5 0\n" + body)));
  expect_pyramid(load_mesh(folder.write("a.off", "COFF5 5 0\r\n" + body)));
  expect_pyramid(load_mesh(folder.write("without_extension", "OFF5 5\n" + body)));
  for (const char* start : {"OFFBINARY 5 5 0\n", "4OFF5 5 0\n", "nOFF5 5 0\n"})
    expect_error([&] { load_mesh(folder.write("a.off", start + body)); }, {"a.off", "line 1", "variant"});
}

TEST(Ply, NumbersThatTheHeaderDoesNotKnowArePassedOver) {
  const TempFolder folder;
  expect_pyramid(load_mesh(folder.write(
      "a.ply",
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 5\nproperty list uchar int vertex_indices\nend_header\n0 0 0 255\n1 0 0 255\n\n1 1 0 255\n"
      "0 1 0 255\n.5 .5 1.25 255\n4 3 2 1 0 6 .1 .2 .3 .4 .5 .6\n3 0 1 4\n3 1 2 4 9\n3 2 3 4\n3 3 0 4 0\n")));
}

TEST(Ply, RowsNeedNotBeLines) {
  const TempFolder folder;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 5\nproperty list uchar int vertex_indices\nend_header\n";
  expect_pyramid(load_mesh(folder.write(
      "a.ply", head + "0 0 0 1 0 0 1 1 0 0 1 0\n.5 .5 1.25\n4 3 2 1 0 3 0 1 4 3 1 2 4\n3 2 3 4 3 3 0 4\n")));
  expect_pyramid(load_mesh(folder.write(
      "a.ply", head + "0\n0 0\n1 0 0\n1 1 0\n0 1 0\n.5 .5\n1.25\n4 3 2\n1 0\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n")));
}

/// A tetrahedron as two strips, of which the first turns round a corner.
TEST(Ply, ElementsWithoutRowsOrCorners) {
  const TempFolder folder;
  const std::string vertices =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string rows = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  const auto edgeless = folder.write("a.ply", vertices +
                                                  "element face 1\nproperty list uchar int vertex_indices\n"
                                                  "element edge 0\nend_header\n" +
                                                  rows);
  EXPECT_EQ(load_mesh(edgeless).mesh.triangles.size(), 1u);
  const auto other =
      folder.write("b.ply", vertices + "element face 1\nproperty list uchar int corners\nend_header\n" + rows);
  expect_error([&] { load_mesh(other); }, {"b.ply", "element face has no list vertex_indices"});
}

TEST(Ply, TriangleStrips) {
  const TempFolder folder;
  const std::string vertices = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  const auto head = [](const std::string& list) {
    return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
           "element tristrips 1\nproperty list int " +
           list + " vertex_indices\nend_header\n";
  };
  const std::vector<Triangle> triangles{{0, 2, 1}, {1, 2, 3}, {2, 0, 3}, {0, 1, 3}};
  for (const auto& [list, end] : {std::pair{"int", "-1"}, std::pair{"uint", "4294967295"}}) {
    const LoadedMesh loaded =
        load_mesh(folder.write("a.ply", head(list) + vertices + "9 0 2 1 3 " + end + " 2 0 3 " + end + "\n"));
    EXPECT_EQ(loaded.diagnosis.triangles, 3u);
    const LoadedMesh closed =
        load_mesh(folder.write("a.ply", head(list) + vertices + "12 0 2 1 3 " + end + " 2 0 3 3 3 0 1\n"));
    EXPECT_NEAR(closed.diagnosis.signed_volume, 1.0 / 6, 1e-9);
    EXPECT_EQ(closed.diagnosis.boundary_edges + closed.diagnosis.inconsistent_edges, 0u);
    EXPECT_THAT(closed.diagnosis.warnings(), testing::IsEmpty());
  }
  expect_error([&] { load_mesh(folder.write("a.ply", head("int") + vertices + "4 0 2 1 4\n")); },
               {"a.ply", "vertex 4", "there are 4"});
}

/// The surface of an L of three cubes: twice its three squares, and its outline of eight edges.
TEST(MeshFiles, ConcavePolygonsKeepTheirShape) {
  const TempFolder folder;
  const std::vector<std::array<int, 2>> outline{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  std::string obj, ply, off;
  for (const int z : {0, 1})
    for (const auto& [x, y] : outline) {
      const std::string place = std::to_string(x) + ' ' + std::to_string(y) + ' ' + std::to_string(z) + '\n';
      obj += "v " + place;
      ply += place;
      off += place;
    }
  std::vector<std::vector<int>> faces{{5, 4, 3, 2, 1, 0}, {6, 7, 8, 9, 10, 11}};
  for (int i = 0; i < 6; ++i) faces.push_back({i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6});
  for (const std::vector<int>& face : faces) {
    std::string corners, from_1, from_behind;
    for (const int corner : face) {
      corners += ' ' + std::to_string(corner);
      from_1 += ' ' + std::to_string(corner + 1);
      from_behind += ' ' + std::to_string(corner - 12);
    }
    obj += 'f' + (face.size() > 4 ? from_behind : from_1) + '\n';
    ply += std::to_string(face.size()) + corners + '\n';
    off += std::to_string(face.size()) + corners + '\n';
  }
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 12\nproperty double x\nproperty double y\nproperty double z\n"
      "element face 8\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& file :
       {folder.write("l.obj", obj), folder.write("l.ply", head + ply), folder.write("l.off", "OFF\n12 8 0\n" + off)}) {
    const LoadedMesh loaded = load_mesh(file);
    double area = 0;
    for (std::size_t t = 0; t < loaded.mesh.triangles.size(); ++t) area += loaded.mesh.area_normal(t).norm() / 2;
    EXPECT_NEAR(area, 2 * 3 + 8, 1e-5) << file;
    EXPECT_NEAR(loaded.diagnosis.signed_volume, 3, 1e-6);
    EXPECT_THAT(loaded.diagnosis.warnings(), testing::IsEmpty());
  }
}

TEST(MeshFiles, ACoordinateThatNoRayReachesIsRefused) {
  const TempFolder folder;
  for (const std::string far : {"1e19", "-2e9", "1e300"}) {
    const std::string vertices = far + " 0 0\n1 0 0\n0 1 0\n";
    expect_error([&] { load_mesh(folder.write("a.off", "OFF\n3 1 0\n" + vertices + "3 0 1 2\n")); },
                 {"a.off", "line 3", "10^9 m"});
    expect_error([&] { load_mesh(folder.write("a.obj", "v 0 0 0\nv 0 " + far + " 0\nv 0 1 1\nf 1 2 3\n")); },
                 {"a.obj", "line 2", "10^9 m"});
    expect_error(
        [&] {
          load_mesh(folder.write("a.ply",
                                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
                                 "property double z\nelement face 1\nproperty list uchar int vertex_indices\n"
                                 "end_header\n" +
                                     vertices + "3 0 1 2\n"));
        },
        {"a.ply", "vertex 0", "10^9 m"});
  }
}

TEST(MeshFiles, MissingFolderOrUnknown) {
  const TempFolder folder;
  expect_error([&] { load_mesh(folder.path() / "none.ply"); }, {"none.ply", "no such file"});
  expect_error([&] { load_mesh(folder.path()); }, {"regular file"});
  expect_error([&] { load_mesh(folder.write("a.stl", "solid")); },
               {"a.stl", "neither PLY nor OBJ nor OFF", "export it"});
  expect_error([&] { load_mesh(folder.write("a.ply", "")); }, {"a.ply", "is empty"});
}

TEST(MeshFiles, SavedAndReadAgainBitForBit) {
  const TempFolder folder;
  Mesh mesh{kPyramid, kPyramidTriangles};
  mesh.vertices[4] = {0.1f, std::numeric_limits<float>::denorm_min(), -3.3f};
  mesh.triangles.push_back({1, 1, 2});  // no area: only loading unchanged keeps it
  save_ply(mesh, folder.path() / "out.ply");
  const Mesh again = load_mesh_unchanged(folder.path() / "out.ply");
  EXPECT_EQ(again.vertices, mesh.vertices);
  EXPECT_EQ(again.triangles, mesh.triangles);
  EXPECT_EQ(load_mesh(folder.path() / "out.ply").diagnosis.removed_degenerate, 1u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1) << "nothing unfinished is left";
  expect_error([&] { save_ply(mesh, folder.path() / "no_folder" / "out.ply"); }, {"no_folder", "cannot be written"});
  expect_error([&] { save_ply(mesh, "/dev/full/out.ply"); }, {"cannot be written"});
}

TEST(MeshFiles, MeshesOfThePublicCollections) {
  const std::filesystem::path folder = shared_data("meshes_clean");
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no shared data";
  std::map<std::string, std::size_t> triangles;
  for (const char* name : {"spot_6k_uv.obj", "teapot_3k_decimated.ply", "head_2.9k.off", "penguin_6.7k.obj"}) {
    const LoadedMesh loaded = load_mesh(folder / name);
    EXPECT_TRUE(std::all_of(loaded.mesh.vertices.begin(), loaded.mesh.vertices.end(),
                            [](const Eigen::Vector3f& v) { return v.allFinite(); }));
    triangles[name] = loaded.diagnosis.triangles;
  }
  EXPECT_GT(triangles["spot_6k_uv.obj"], 5000u);
  EXPECT_LT(triangles["spot_6k_uv.obj"], 7000u);
  EXPECT_GT(triangles["head_2.9k.off"], 2500u);
}

Mesh pyramid_with_evidence() {
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          .triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}},
          .evidence = {ShapeEvidence::kGuessed, ShapeEvidence::kOutline, ShapeEvidence::kSeen, ShapeEvidence::kSeen}};
}

TEST(MeshIo, KeepsFromWhatAVertexIsKnown) {
  const TempFolder folder;
  const Mesh mesh = pyramid_with_evidence();
  save_ply(mesh, folder.path() / "shape.ply");
  EXPECT_EQ(load_mesh_unchanged(folder.path() / "shape.ply").evidence, mesh.evidence);
  EXPECT_EQ(load_mesh(folder.path() / "shape.ply").mesh.evidence, mesh.evidence);
  EXPECT_EQ(share_known_as(ShapeEvidence::kSeen, mesh), 0.5);
  EXPECT_EQ(share_known_as(ShapeEvidence::kSeen, Mesh{}), 0);
  EXPECT_TRUE(mesh.guessed_at(0));
  EXPECT_FALSE(mesh.guessed_at(1));
  EXPECT_FALSE(Mesh{}.guessed_at(0));
}

TEST(MeshIo, EvidenceStaysWithItsVertexWhereOthersAreDropped) {
  const TempFolder folder;
  Mesh mesh = pyramid_with_evidence();
  mesh.vertices.insert(mesh.vertices.begin() + 1, Eigen::Vector3f(7, 7, 7));  // of no triangle
  mesh.evidence.insert(mesh.evidence.begin() + 1, ShapeEvidence::kSeen);
  for (Triangle& triangle : mesh.triangles)
    for (std::uint32_t& v : triangle) v += v > 0 ? 1 : 0;
  save_ply(mesh, folder.path() / "shape.ply");
  EXPECT_EQ(load_mesh(folder.path() / "shape.ply").mesh.evidence, pyramid_with_evidence().evidence);
}

TEST(MeshIo, AnotherProgramsEvidenceIsNotOurs) {
  const TempFolder folder;
  const auto with = [&](const std::string& type, const std::string& value) {
    write_file(folder.path() / "a.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
               "property float z\nproperty " +
                   type +
                   " evidence\nelement face 1\n"
                   "property list uchar int vertex_indices\nend_header\n0 0 0 1\n1 0 0 " +
                   value + "\n0 1 0 1\n3 0 1 2\n");
    return load_mesh(folder.path() / "a.ply").mesh.evidence.size();
  };
  EXPECT_EQ(with("uchar", "1"), 3u);
  EXPECT_EQ(with("uchar", "3"), 0u) << "no such evidence";
  EXPECT_EQ(with("float", "1"), 0u);
}

}  // namespace
}  // namespace sheen
