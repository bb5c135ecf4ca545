// SPDX-License-Identifier: Apache-2.0
// Meshes with a texture for other programs, against closed forms: colours that are the places on the surface.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <set>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/color.h"
#include "common/image/image_io.h"
#include "common/image/jpeg.h"
#include "reconstructor/exchange/charts.h"
#include "reconstructor/exchange/mesh_files.h"
#include "reconstructor/exchange/texture_atlas.h"
#include "tests/support/plain_model.h"
#include "tests/support/process.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// A ramp that winds two and a half times round an axis: flat enough everywhere to be one chart, but for its turns that
/// lie over each other.
Mesh winding_ramp() {
  constexpr int kSteps = 100;
  Mesh mesh;
  for (int i = 0; i <= kSteps; ++i) {
    const float turn = 5 * std::numbers::pi_v<float> * static_cast<float>(i) / kSteps;
    for (const float radius : {0.1f, 0.2f})
      mesh.vertices.emplace_back(radius * std::cos(turn), radius * std::sin(turn), 0.004f * turn);
  }
  for (std::uint32_t i = 0; i < 2 * kSteps; i += 2) {
    mesh.triangles.push_back({i, i + 1, i + 3});
    mesh.triangles.push_back({i, i + 3, i + 2});
  }
  return mesh;
}

/// As a scan is: the sphere's vertices at random up to a fifth of its radius off.
Mesh rough_sphere() {
  Mesh mesh = sphere_mesh(0.3f, 3);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> off(0.8f, 1.2f);
  for (Vector3f& vertex : mesh.vertices) vertex *= off(random);
  return mesh;
}

std::vector<Mesh> meshes() {
  return {sphere_mesh(0.3f, 3), rough_sphere(), winding_ramp()};
}

float cross(const Vector2f& a, const Vector2f& b) {
  return a.x() * b.y() - a.y() * b.x();
}

bool inside(const FlatTriangle& triangle, const Vector2f& point) {
  bool in = true;
  for (int c = 0; c < 3; ++c)  // y runs down: clockwise seen from outside
    in &= cross(triangle.corners[(c + 1) % 3] - triangle.corners[c], point - triangle.corners[c]) < 0;
  return in;
}

TEST(Charts, EveryTriangleIsInOneAndFacesItsSide) {
  for (const Mesh& mesh : meshes()) {
    std::multiset<std::uint32_t> triangles;
    for (const Chart& chart : cut_into_charts(mesh)) {
      EXPECT_TRUE((chart.plane * chart.plane.transpose()).isIdentity(1e-5f));
      const Vector3f side = chart.plane.row(0).transpose().cross(chart.plane.row(1).transpose());
      for (const std::uint32_t t : chart.triangles) {
        triangles.insert(t);
        EXPECT_GT(mesh.area_normal(t).normalized().dot(side), 0.34f);
      }
    }
    EXPECT_EQ(triangles.size(), mesh.triangles.size());
    EXPECT_EQ(std::set(triangles.begin(), triangles.end()).size(), mesh.triangles.size());
  }
  const Mesh sphere = sphere_mesh(0.3f, 3);
  EXPECT_LT(cut_into_charts(sphere).size(), 20u) << "not a chart a triangle";
  EXPECT_EQ(cut_into_charts(triangle_soup(sphere)).size(), cut_into_charts(sphere).size());
}

TEST(TextureAtlas, NothingLiesOverAnythingElse) {
  for (const Mesh& mesh : meshes()) {
    const TextureAtlas atlas = texture_atlas(mesh, 512);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0.02f, 1);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& corners = atlas.triangles[t].corners;
      Vector3f weights(uniform(random), uniform(random), uniform(random));
      weights /= weights.sum();
      const Vector2f point = weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
      for (std::size_t s = 0; s < mesh.triangles.size(); ++s)
        if (s != t && inside(atlas.triangles[s], point)) ADD_FAILURE() << s << " over " << t;
    }
  }
}

TEST(TextureAtlas, ChartsKeepTheirShapeInOneScaleAndTheirDistance) {
  constexpr int kSide = 512;
  for (const Mesh& mesh : meshes()) {
    const TextureAtlas atlas = texture_atlas(mesh, kSide);
    float longest = 0, shortest = 1e9f;
    std::vector<Eigen::AlignedBox2f> boxes(1 + *std::ranges::max_element(atlas.chart));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int c = 0; c < 3; ++c) {
        const Vector2f& corner = atlas.triangles[t].corners[c];
        boxes[atlas.chart[t]].extend(corner);
        const float scale = (atlas.triangles[t].corners[(c + 1) % 3] - corner).norm() /
                            (mesh.corner(t, (c + 1) % 3) - mesh.corner(t, c)).norm();
        longest = std::max(longest, scale);
        shortest = std::min(shortest, scale);
      }
    EXPECT_GT(shortest, 0.33f * longest);
    EXPECT_GT(longest, 0) << "not all at one place";
    for (std::size_t a = 0; a < boxes.size(); ++a) {
      EXPECT_GE(boxes[a].min().minCoeff(), kGutter - 0.01f);
      EXPECT_LE(boxes[a].max().maxCoeff(), kSide - kGutter + 0.01f);
      for (std::size_t b = 0; b < a; ++b) {
        const Vector2f apart = (boxes[a].min() - boxes[b].max()).cwiseMax(boxes[b].min() - boxes[a].max());
        EXPECT_GE(apart.maxCoeff(), 2 * kGutter - 0.01f) << a << ' ' << b;
      }
    }
  }
}

TEST(TextureAtlas, MorePiecesThanTexelsAreRefused) {
  Mesh mesh;
  for (int i = 0; i < 600; ++i) {
    const auto x = static_cast<float>(i);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vector3f& corner : {Vector3f(x, 0, 0), Vector3f(x + 0.5f, 0, 0), Vector3f(x, 0.5f, 0)})
      mesh.vertices.push_back(corner);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_THROW(texture_atlas(mesh, 128), ConfigError);
  EXPECT_EQ(texture_atlas(mesh, 512).triangles.size(), 600u);
}

class MeshFiles : public ::testing::Test {
 protected:
  /// Its colour is the place, moved into 0.2 .. 0.8.
  TexturedMesh textured(const Mesh& mesh, std::size_t samples = 100'000) const {
    Mesh* const coloured = keep_.emplace_back(std::make_unique<Mesh>(mesh)).get();
    for (Vector3f& vertex : coloured->vertices) vertex = vertex.array() + 0.5f;
    testing::PlainModel* const model = models_.emplace_back(std::make_unique<testing::PlainModel>(*coloured)).get();
    model->shows_place = true;
    return textured_mesh(mesh, AverageLook{model->shader_for({}), samples}, 1024);
  }
  static Vector3f colour_at(const ImageU8& picture, const Vector2f& place) {
    const Vector2f at = place * static_cast<float>(picture.width()) - Vector2f(0.5f, 0.5f);
    const auto x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y()));
    const float fx = at.x() - static_cast<float>(x), fy = at.y() - static_cast<float>(y);
    Vector3f colour = Vector3f::Zero();
    for (int c = 0; c < 3; ++c)
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i)
          colour[c] += (i ? fx : 1 - fx) * (j ? fy : 1 - fy) * static_cast<float>(picture.at(x + i, y + j, c));
    return colour;
  }
  static Vector3f expected_at(const Vector3f& place) {
    ImageF linear(1, 1, 3);
    for (int c = 0; c < 3; ++c) linear.at(0, 0, c) = place[c] + 0.5f;
    const ImageU8 codes = to_srgb8(linear);
    return {float(codes.at(0, 0, 0)), float(codes.at(0, 0, 1)), float(codes.at(0, 0, 2))};
  }
  void expect_opened_by_assimp(const fs::path& file) const {
    std::error_code none;
    if (!fs::exists("/usr/bin/assimp", none)) GTEST_SKIP() << "no assimp here (Debian: assimp-utils)";
    testing::Process assimp({"/usr/bin/assimp", "info", file});
    const auto end = assimp.wait(std::chrono::seconds(60));
    ASSERT_TRUE(end);
    EXPECT_EQ(end->status, 0) << assimp.output();
    EXPECT_THAT(assimp.output(), ::testing::HasSubstr("Faces:              1280")) << file;
  }

  const TempFolder temp_;
  mutable std::vector<std::unique_ptr<Mesh>> keep_;
  mutable std::vector<std::unique_ptr<testing::PlainModel>> models_;
};

TEST_F(MeshFiles, ThePictureShowsEveryPlaceInItsColour) {
  for (const Mesh& mesh : meshes()) {
    const TexturedMesh result = textured(mesh);
    ASSERT_EQ(result.mesh.triangles.size(), mesh.triangles.size());
    ASSERT_EQ(result.place.size(), result.mesh.vertices.size());
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(0, 1);
    float worst = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Triangle& corners = result.mesh.triangles[t];
      for (int c = 0; c < 3; ++c) ASSERT_EQ(result.mesh.corner(t, c), mesh.corner(t, c));
      float u = uniform(random), v = uniform(random);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vector2f at =
          (1 - u - v) * result.place[corners[0]] + u * result.place[corners[1]] + v * result.place[corners[2]];
      const Vector3f point = (1 - u - v) * mesh.corner(t, 0) + u * mesh.corner(t, 1) + v * mesh.corner(t, 2);
      worst = std::max(worst, (colour_at(result.picture, at) - expected_at(point)).cwiseAbs().maxCoeff());
    }
    EXPECT_LE(worst, 3) << "levels of 255: a texel and a half at a triangle's edge, and rounding";
  }
}

TEST_F(MeshFiles, MipmapsMixNothingInThatIsNotThere) {
  Mesh mesh = sphere_mesh(0.3f, 3);
  testing::PlainModel white(mesh);
  const TexturedMesh result = textured_mesh(mesh, AverageLook{white.shader_for({}), 20'000}, 256);
  for (std::size_t i = 0; i < result.picture.size(); ++i) ASSERT_EQ(result.picture.data()[i], 255);
}

std::uint32_t u32_at(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

TEST_F(MeshFiles, AGlbIsWhatTheFormatSays) {
  const Mesh mesh = sphere_mesh(0.3f, 3);
  const TexturedMesh result = textured(mesh);
  const fs::path file = temp_.path() / "ball.glb";
  write_glb(file, result, upright(Vector3d::UnitZ()));

  const std::string bytes = read_file(file);
  ASSERT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(u32_at(bytes, 4), 2u);
  EXPECT_EQ(u32_at(bytes, 8), bytes.size());
  const std::uint32_t json_bytes = u32_at(bytes, 12);
  EXPECT_EQ(json_bytes % 4, 0u);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  const auto json = nlohmann::json::parse(bytes.substr(20, json_bytes));
  const std::size_t binary = 20 + json_bytes + 8;
  EXPECT_EQ(bytes.substr(binary - 4, 4), std::string("BIN\0", 4));
  EXPECT_EQ(u32_at(bytes, binary - 8), json["buffers"][0]["byteLength"]);
  EXPECT_EQ(binary + u32_at(bytes, binary - 8), bytes.size());
  EXPECT_EQ(json["asset"]["version"], "2.0");

  const auto& primitive = json["meshes"][0]["primitives"][0];
  const auto floats = [&](const std::string& name, int parts) {
    const auto& accessor = json["accessors"][primitive["attributes"][name].get<int>()];
    const auto& view = json["bufferViews"][accessor["bufferView"].get<int>()];
    EXPECT_EQ(accessor["count"], result.mesh.vertices.size());
    EXPECT_EQ(view["byteLength"], 4 * parts * result.mesh.vertices.size());
    std::vector<float> values(parts * result.mesh.vertices.size());
    std::memcpy(values.data(), bytes.data() + binary + view["byteOffset"].get<std::size_t>(), 4 * values.size());
    return values;
  };
  const std::vector<float> positions = floats("POSITION", 3), normals = floats("NORMAL", 3),
                           places = floats("TEXCOORD_0", 2);
  Vector3f low = Vector3f::Constant(1e9f), high = -low;
  for (std::size_t i = 0; i < result.mesh.vertices.size(); ++i) {
    const Vector3f& ours = result.mesh.vertices[i];
    const Vector3f written(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
    EXPECT_EQ(written, Vector3f(ours.x(), ours.z(), -ours.y())) << "z up becomes y up";
    low = low.cwiseMin(written);
    high = high.cwiseMax(written);
    const Vector3f normal(normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]);
    EXPECT_NEAR(normal.norm(), 1, 1e-5);
    EXPECT_GT(normal.dot(written.normalized()), 0.95f);
    EXPECT_EQ(Vector2f(places[2 * i], places[2 * i + 1]), result.place[i]);
  }
  const auto& position = json["accessors"][primitive["attributes"]["POSITION"].get<int>()];
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(position["min"][k].get<float>(), low[k]);
    EXPECT_EQ(position["max"][k].get<float>(), high[k]);
  }
  const auto& indices = json["accessors"][primitive["indices"].get<int>()];
  EXPECT_EQ(indices["count"], 3 * mesh.triangles.size());
  const auto& jpeg = json["bufferViews"][json["images"][0]["bufferView"].get<int>()];
  const ImageU8 picture =
      decode_jpeg(std::string_view(bytes).substr(binary + jpeg["byteOffset"].get<std::size_t>(), jpeg["byteLength"]));
  EXPECT_EQ(picture.width(), result.picture.width());
  EXPECT_TRUE(json["materials"][0]["extensions"].contains("KHR_materials_unlit"));
  expect_opened_by_assimp(file);
}

TEST_F(MeshFiles, PlyAndObjStandInTheMeshesFrame) {
  Mesh mesh = sphere_mesh(0.3f, 3);
  mesh.origin = Vector3d(4'000'000, 500'000, 100);
  const TexturedMesh result = textured(mesh);
  const fs::path ply = temp_.path() / "a ball.ply", obj = temp_.path() / "ball.obj";
  write_textured_ply(ply, result);
  write_obj(obj, result);
  EXPECT_THAT(read_file(ply).substr(0, 600), ::testing::HasSubstr("comment TextureFile a ball.png\n"));
  EXPECT_EQ(read_image(temp_.path() / "a ball.png").width, result.picture.width());
  EXPECT_THAT(read_file(temp_.path() / "ball.mtl"), ::testing::HasSubstr("map_Kd ball.png"));
  for (const fs::path& file : {ply, obj}) {
    const Mesh again = load_mesh_unchanged(file);
    ASSERT_EQ(again.triangles, result.mesh.triangles) << file;
    for (std::size_t i = 0; i < again.vertices.size(); ++i)
      EXPECT_NEAR(
          ((again.vertices[i].cast<double>() + again.origin) - (result.mesh.vertices[i].cast<double>() + mesh.origin))
              .norm(),
          0, 1e-6);
  }
  std::istringstream lines(read_file(obj));
  std::size_t i = 0;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("vt ")) {
      std::istringstream words(line.substr(3));
      float s = 0, t = 0;
      words >> s >> t;
      EXPECT_NEAR(s, result.place[i].x(), 1e-6);
      EXPECT_NEAR(t, 1 - result.place[i].y(), 1e-6) << "upwards";
      ++i;
    }
  EXPECT_EQ(i, result.place.size());
  expect_opened_by_assimp(obj);
}

TEST(Upright, TheNearestAxisPointsUpAndNothingIsMirrored) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      Vector3d up(0.1, -0.2, 0.15);
      up[axis] = sign;
      const Eigen::Matrix3f turn = upright(up);
      EXPECT_EQ(turn * (sign * Vector3d::Unit(axis)).cast<float>(), Vector3f(0, 1, 0));
      EXPECT_EQ(turn.determinant(), 1);
    }
}

}  // namespace
}  // namespace sheen
