// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/mesh_coding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <set>
#include <string>

#include "reconstructor/light_field_file/encode/canonical_mesh.h"
#include "reconstructor/light_field_file/encode/resolution_encoding.h"
#include "reconstructor/light_field_file/encode/state_encoding.h"
#include "reconstructor/light_field_file/resolution_coding.h"
#include "reconstructor/light_field_file/state_coding.h"
#include "reconstructor/surface/map_resolution.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

/// Each triangle of the stored mesh is the old one, turned by its first corner.
void expect_same_surface(const Mesh& mesh) {
  const CanonicalMesh canonical = canonical_mesh(mesh);
  ASSERT_EQ(canonical.mesh->triangles.size(), mesh.triangles.size());
  const double side = 2 * bounding_sphere(mesh).radius;
  std::set<std::uint32_t> used(canonical.old_triangle.begin(), canonical.old_triangle.end());
  EXPECT_EQ(used.size(), mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      const int old = (c + canonical.first_corner[t]) % 3;
      EXPECT_EQ(canonical.old_vertex[canonical.mesh->triangles[t][static_cast<std::size_t>(c)]],
                mesh.triangles[canonical.old_triangle[t]][static_cast<std::size_t>(old)]);
      EXPECT_LT((canonical.mesh->corner(t, c) - mesh.corner(canonical.old_triangle[t], old)).norm(), 2e-5 * side);
    }
  const Mesh again = decode_mesh(canonical.bytes).mesh();
  EXPECT_EQ(again.triangles, canonical.mesh->triangles);
  EXPECT_EQ(again.vertices, canonical.mesh->vertices);
}

TEST(CanonicalMesh, IsTheSameSurfaceInAnotherOrder) {
  expect_same_surface(sphere_mesh(0.3f, 3));
  expect_same_surface(square_mesh(0.1f, 0, 8));
}

TEST(CanonicalMesh, TakesOddMeshes) {
  Mesh odd = square_mesh(0.1f, 0, 3);
  odd.triangles.push_back(odd.triangles[4]);                                                 // twice
  odd.triangles.push_back({odd.triangles[5][1], odd.triangles[5][0], odd.triangles[5][2]});  // and from behind
  odd.vertices.push_back({5, 5, 5});                                                         // in no triangle
  const CanonicalMesh canonical = canonical_mesh(odd);
  EXPECT_EQ(canonical.mesh->triangles.size(), odd.triangles.size());
  EXPECT_EQ(canonical.mesh->vertices.size(), odd.vertices.size() - 1);
  const std::set<std::uint32_t> used(canonical.old_triangle.begin(), canonical.old_triangle.end());
  EXPECT_EQ(used.size(), odd.triangles.size());
}

TEST(MeshCoding, AnyTrianglesComeBack) {
  std::mt19937 random(4);
  for (int i = 0; i < 300; ++i) {
    GridMesh mesh;
    mesh.points.resize(1 + random() % 40);
    for (GridMesh::Point& point : mesh.points)
      for (std::int32_t& at : point) at = static_cast<std::int32_t>(random() % (1 << 22)) - (1 << 21);
    mesh.triangles.resize(1 + random() % 200);
    for (Triangle& triangle : mesh.triangles)
      for (std::uint32_t& v : triangle) v = static_cast<std::uint32_t>(random() % mesh.points.size());
    const CodedMesh coded = encode_mesh(mesh);
    ASSERT_EQ(coded.grid.triangles.size(), mesh.triangles.size());
    const std::set<std::uint32_t> used(coded.old_triangle.begin(), coded.old_triangle.end());
    ASSERT_EQ(used.size(), mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t v = coded.grid.triangles[t][c];
        ASSERT_EQ(coded.old_vertex[v], mesh.triangles[coded.old_triangle[t]][(c + coded.first_corner[t]) % 3]);
        ASSERT_EQ(coded.grid.points[v], mesh.points[coded.old_vertex[v]]);
      }
    const GridMesh read = decode_mesh(coded.bytes);
    ASSERT_EQ(read.triangles, coded.grid.triangles);
    ASSERT_EQ(read.points, coded.grid.points);
  }
}

double bits_per_triangle(const CanonicalMesh& mesh) {
  return 8.0 * static_cast<double>(mesh.bytes.size()) / static_cast<double>(mesh.mesh->triangles.size());
}

TEST(MeshCoding, WhatIsRegularCostsFewBits) {
  // A parallelogram foretells a vertex of a lattice in the plane exactly, and the gap which corner follows an edge.
  EXPECT_LT(bits_per_triangle(canonical_mesh(square_mesh(0.1f, 0, 64))), 1.0);
  // 256 lengths of edges of a sphere whose vertices have six neighbours: what is left is that it is round.
  EXPECT_LT(bits_per_triangle(canonical_mesh(sphere_mesh(0.3f, 5))), 12.0);
}

/// Calls `read` with bytes that are cut short or have other ones among them; it may throw std::runtime_error alone.
void damage(const std::string& bytes, const std::function<void(const std::string&)>& read, int times = 2000) {
  std::mt19937 random(5);
  for (int i = 0; i < times; ++i) {
    std::string damaged = bytes.substr(0, i % 4 == 0 ? random() % bytes.size() : bytes.size());
    for (int k = 0; k < 3 && !damaged.empty(); ++k) damaged[random() % damaged.size()] = static_cast<char>(random());
    try {
      read(damaged);
    } catch (const std::runtime_error&) {
    }
  }
}

TEST(MeshCoding, AGridOfNoSizeOrBeyondAllMeasureIsRefused) {
  const std::string bytes = canonical_mesh(sphere_mesh(0.3f, 2)).bytes;
  for (const float value : {NAN, INFINITY, -1e30f, 1e25f})
    for (const std::size_t at : {4, 8, 12, 16}) {  // origin, step
      std::string damaged = bytes;
      std::memcpy(damaged.data() + at, &value, sizeof value);
      EXPECT_THROW(decode_mesh(damaged), std::runtime_error) << value << " at " << at;
    }
}

TEST(MeshCoding, DamagedBytesAreRefused) {
  damage(canonical_mesh(sphere_mesh(0.3f, 2)).bytes, [](const std::string& bytes) {
    const Mesh mesh = decode_mesh(bytes).mesh();
    for (const Triangle& triangle : mesh.triangles)
      for (const std::uint32_t v : triangle) ASSERT_LT(v, mesh.vertices.size());
  });
}

/// The lattices that a camera in front of a sphere asks for.
std::vector<std::uint8_t> resolutions_for_a_camera(const Mesh& mesh, const MapResolutionOptions& options = {}) {
  Camera camera;
  camera.width = camera.height = 600;
  camera.fx = camera.fy = 600;
  camera.cx = camera.cy = 300;
  Rigid3 camera_from_object;
  camera_from_object.translation = {0, 0, 1};
  return map_resolution(mesh, camera, camera_from_object, options);
}

TEST(ResolutionCoding, ThoseThatFollowTheEdgesCostNothing) {
  const CanonicalMesh mesh = canonical_mesh(sphere_mesh(0.3f, 4));
  const std::vector<std::uint8_t> resolutions = resolutions_for_a_camera(*mesh.mesh);
  ASSERT_GT(std::set<std::uint8_t>(resolutions.begin(), resolutions.end()).size(), 2u);
  const std::string bytes = encode_resolutions(mesh.grid, resolutions);
  EXPECT_EQ(decode_resolutions(mesh.grid, bytes), resolutions);
  EXPECT_LT(bytes.size(), 40u) << "for " << resolutions.size() << " triangles";
}

TEST(ResolutionCoding, ALargestNumberIsFoundWithThem) {
  Mesh rough = sphere_mesh(0.3f, 4);
  std::mt19937 random(8);
  for (Eigen::Vector3f& vertex : rough.vertices) vertex *= std::uniform_real_distribution<float>(0.8f, 1.2f)(random);
  const CanonicalMesh mesh = canonical_mesh(rough);
  std::vector<std::uint8_t> resolutions = resolutions_for_a_camera(*mesh.mesh);
  std::nth_element(resolutions.begin(), resolutions.begin() + 1500, resolutions.end());
  resolutions = resolutions_for_a_camera(*mesh.mesh, {.largest = resolutions[1500]});
  ASSERT_GT(std::set<std::uint8_t>(resolutions.begin(), resolutions.end()).size(), 8u);
  const std::string bytes = encode_resolutions(mesh.grid, resolutions);
  EXPECT_EQ(decode_resolutions(mesh.grid, bytes), resolutions);
  EXPECT_LT(bytes.size(), 80u) << "for " << resolutions.size() << " triangles";
}

TEST(ResolutionCoding, AnyComeBackAndDamageIsRefused) {
  const CanonicalMesh mesh = canonical_mesh(sphere_mesh(0.3f, 3));
  std::mt19937 random(6);
  std::vector<std::uint8_t> resolutions(mesh.mesh->triangles.size());
  for (std::uint8_t& resolution : resolutions) resolution = static_cast<std::uint8_t>(2 + random() % 254);
  const std::string bytes = encode_resolutions(mesh.grid, resolutions);
  EXPECT_EQ(decode_resolutions(mesh.grid, bytes), resolutions);
  damage(bytes, [&](const std::string& damaged) {
    for (const std::uint8_t resolution : decode_resolutions(mesh.grid, damaged)) ASSERT_GE(resolution, 2);
  });
}

/// A model of nothing but states.
CompactModel model_with_states(const std::function<SampleState(const Eigen::Vector3f&)>& state_at) {
  CompactModel model;
  const CanonicalMesh mesh = canonical_mesh(sphere_mesh(0.3f, 4));
  model.mesh = mesh.mesh;
  model.maps = std::make_shared<MapLayout>(resolutions_for_a_camera(*mesh.mesh));
  model.shapes = cut_into_patches(*model.mesh, *model.maps, {});
  for (const PatchShape& shape : model.shapes.patches) model.patches.emplace_back().state.resize(shape.samples);
  for (std::size_t t = 0; t < model.mesh->triangles.size(); ++t) {
    const int n = model.maps->resolution(t);
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const float u = static_cast<float>(i) / static_cast<float>(n - 1),
                    v = static_cast<float>(j) / static_cast<float>(n - 1);
        const Eigen::Vector3f at =
            (1 - u - v) * model.mesh->corner(t, 0) + u * model.mesh->corner(t, 1) + v * model.mesh->corner(t, 2);
        model.patches[model.shapes.patch_of[t]]
            .state[model.shapes.first_sample[t] + static_cast<std::size_t>(lattice_index(n, i, j))] = state_at(at);
      }
  }
  return model;
}

void expect_states_come_back(const CompactModel& model) {
  CompactModel read = model;
  for (Patch& patch : read.patches) std::fill(patch.state.begin(), patch.state.end(), SampleState::kUnseen);
  decode_states(encode_states(model), read);
  for (std::size_t p = 0; p < model.patches.size(); ++p) ASSERT_EQ(read.patches[p].state, model.patches[p].state);
}

TEST(StateCoding, ABorderCostsBitsOnlyWhereItIs) {
  const CompactModel model = model_with_states([](const Eigen::Vector3f& at) {
    return at.z() > 0.1f ? SampleState::kMeasured : at.z() > 0 ? SampleState::kImputed : SampleState::kUnseen;
  });
  expect_states_come_back(model);
  // Two circles: about a bit for each sample on them.
  std::size_t on_border = 0;
  for (std::size_t t = 0; t < model.mesh->triangles.size(); ++t) {
    const float a = model.mesh->corner(t, 0).z(), b = model.mesh->corner(t, 1).z(), c = model.mesh->corner(t, 2).z();
    for (const float border : {0.1f, 0.0f})
      if (std::min({a, b, c}) <= border && std::max({a, b, c}) > border)
        on_border += static_cast<std::size_t>(model.maps->resolution(t));
  }
  EXPECT_LT(8.0 * static_cast<double>(encode_states(model).size()), 1.5 * static_cast<double>(on_border));
}

TEST(StateCoding, AnyComeBackAndDamageIsHarmless) {
  std::mt19937 random(7);
  const CompactModel model =
      model_with_states([&](const Eigen::Vector3f&) { return static_cast<SampleState>(random() % 3); });
  expect_states_come_back(model);
  CompactModel read = model;
  const auto read_states = [&](const std::string& damaged) {
    decode_states(damaged, read);
    for (const Patch& patch : read.patches)
      for (const SampleState state : patch.state) ASSERT_LE(static_cast<int>(state), 2);
  };
  damage(encode_states(model), read_states, 50);
}

}  // namespace
}  // namespace sheen
