// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/exchange/mesh_files.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/geometry/mesh_io.h"
#include "common/image/image_io.h"

namespace sheen {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kJpegQuality = 95;

/// Of glTF 2.0 and OpenGL.
enum GltfNumber : std::uint32_t {
  kFloat = 5126,
  kUnsignedInt = 5125,
  kVertices = 34962,
  kIndices = 34963,
  kLinear = 9729,
  kLinearMipmapLinear = 9987,
  kClampToEdge = 33071,
};

/// The pieces of a GLB's binary chunk, each at a multiple of four bytes.
class GltfBuffer {
 public:
  /// Index of the view.
  int add(const void* data, std::size_t bytes, std::optional<GltfNumber> target = {}) {
    nlohmann::json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes}};
    if (target) view["target"] = *target;
    bytes_.append(static_cast<const char*>(data), bytes);
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    views_.push_back(std::move(view));
    return static_cast<int>(views_.size()) - 1;
  }
  template <typename T>
  int add(const std::vector<T>& values, GltfNumber target) {
    return add(values.data(), values.size() * sizeof(T), target);
  }
  const std::string& bytes() const { return bytes_; }
  const nlohmann::json& views() const { return views_; }

 private:
  std::string bytes_;
  nlohmann::json views_ = nlohmann::json::array();
};

nlohmann::json accessor(int view, GltfNumber component, std::size_t count, const char* type) {
  return {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}};
}

void append_u32(std::string& bytes, std::size_t value) {
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(value >> 8 * i & 0xff));
}

/// The container: a header and two chunks, JSON and binary.
std::string glb_of(const nlohmann::json& description, const std::string& binary) {
  std::string json = description.dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string glb = "glTF";
  append_u32(glb, 2);
  append_u32(glb, 12 + 8 + json.size() + 8 + binary.size());
  append_u32(glb, json.size());
  glb += "JSON" + json;
  append_u32(glb, binary.size());
  glb += std::string("BIN\0", 4) + binary;
  return glb;
}

std::filesystem::path beside(const std::filesystem::path& path, const char* extension) {
  return std::filesystem::path(path).replace_extension(extension);
}

}  // namespace

Eigen::Matrix3f upright(const Vector3d& up) {
  int axis = 2;
  up.cwiseAbs().maxCoeff(&axis);
  const float sign = up[axis] < 0 ? -1.0f : 1.0f;
  Eigen::Matrix3f turn = Eigen::Matrix3f::Zero();
  turn(0, (axis + 1) % 3) = 1;  // +X of what is written
  turn(1, axis) = sign;         // +Y
  turn(2, (axis + 2) % 3) = -sign;
  return turn;
}

void write_glb(const std::filesystem::path& path, const TexturedMesh& textured, const Eigen::Matrix3f& turn) {
  std::vector<Vector3f> positions, normals;
  Vector3f low = Vector3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  for (const Vector3f& vertex : textured.mesh.vertices) {
    positions.emplace_back(turn * vertex);
    low = low.cwiseMin(positions.back());
    high = high.cwiseMax(positions.back());
  }
  for (const Vector3f& normal : textured.normals) normals.emplace_back((turn * normal).normalized());

  GltfBuffer buffer;
  nlohmann::json position = accessor(buffer.add(positions, kVertices), kFloat, positions.size(), "VEC3");
  position["min"] = {low.x(), low.y(), low.z()};
  position["max"] = {high.x(), high.y(), high.z()};
  const auto& triangles = textured.mesh.triangles;
  const nlohmann::json accessors = {
      std::move(position), accessor(buffer.add(normals, kVertices), kFloat, normals.size(), "VEC3"),
      accessor(buffer.add(textured.place, kVertices), kFloat, textured.place.size(), "VEC2"),
      accessor(buffer.add(triangles, kIndices), kUnsignedInt, 3 * triangles.size(), "SCALAR")};
  const std::vector<std::uint8_t> jpeg = encode_jpeg(textured.picture, kJpegQuality);
  const int picture = buffer.add(jpeg.data(), jpeg.size());

  nlohmann::json node = {{"mesh", 0}, {"name", "object"}};
  const Vector3d& origin = textured.mesh.origin;
  if (origin != Vector3d::Zero())  // single precision would not hold the shape there
    node["extras"] = {{"origin", {origin.x(), origin.y(), origin.z()}}};
  const nlohmann::json description = {
      {"asset", {{"version", "2.0"}, {"generator", "Sheen"}}},
      {"extensionsUsed", {"KHR_materials_unlit"}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes", {node}},
      {"meshes",
       {{{"primitives",
          {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}}, {"indices", 3}, {"material", 0}}}}}}},
      {"materials",
       {{{"name", "mean look"},
         {"pbrMetallicRoughness",
          {{"baseColorTexture", {{"index", 0}}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}},
         {"extensions", {{"KHR_materials_unlit", nlohmann::json::object()}}}}}},
      {"textures", {{{"sampler", 0}, {"source", 0}}}},
      {"samplers",
       {{{"magFilter", kLinear},
         {"minFilter", kLinearMipmapLinear},
         {"wrapS", kClampToEdge},
         {"wrapT", kClampToEdge}}}},
      {"images", {{{"bufferView", picture}, {"mimeType", "image/jpeg"}}}},
      {"accessors", accessors},
      {"bufferViews", buffer.views()},
      {"buffers", {{{"byteLength", buffer.bytes().size()}}}}};
  write_file(path, glb_of(description, buffer.bytes()));
}

void write_textured_ply(const std::filesystem::path& path, const TexturedMesh& textured) {
  constexpr std::array<const char*, 8> kNames{"nx", "ny", "nz", "s", "t", "red", "green", "blue"};
  const std::size_t vertices = textured.mesh.vertices.size();
  std::array<std::vector<float>, kNames.size()> values;
  const int side = textured.picture.width();
  for (std::size_t i = 0; i < vertices; ++i) {
    const Vector2f& place = textured.place[i];
    for (int k = 0; k < 3; ++k) values[k].push_back(textured.normals[i][k]);
    values[3].push_back(place.x());
    values[4].push_back(1 - place.y());
    const auto texel = [&](float at) {
      return std::clamp(static_cast<int>(at * static_cast<float>(side)), 0, side - 1);
    };
    for (int c = 0; c < 3; ++c) values[5 + c].push_back(textured.picture.at(texel(place.x()), texel(place.y()), c));
  }
  std::vector<VertexValues> columns;
  for (std::size_t k = 0; k < kNames.size(); ++k) columns.push_back({kNames[k], values[k], k >= 5});
  const std::filesystem::path picture = beside(path, ".png");
  write_png(picture, textured.picture);
  save_ply(textured.mesh, path, columns, "TextureFile " + picture.filename().string());
}

void write_obj(const std::filesystem::path& path, const TexturedMesh& textured) {
  const std::filesystem::path picture = beside(path, ".png"), material = beside(path, ".mtl");
  std::string obj = "# unit: metre\nmtllib " + material.filename().string() + "\no object\n";
  const bool far = textured.mesh.origin != Vector3d::Zero();
  for (const Vector3f& vertex : textured.mesh.vertices) {
    const Vector3d in_file = vertex.cast<double>() + textured.mesh.origin;
    obj += format(far ? "v %.15g %.15g %.15g\n" : "v %.9g %.9g %.9g\n", in_file.x(), in_file.y(), in_file.z());
  }
  for (const Vector2f& place : textured.place) obj += format("vt %.7g %.7g\n", place.x(), 1 - place.y());
  for (const Vector3f& normal : textured.normals)
    obj += format("vn %.6g %.6g %.6g\n", normal.x(), normal.y(), normal.z());
  obj += "usemtl mean_look\n";
  for (const Triangle& triangle : textured.mesh.triangles) {
    obj += 'f';
    for (const std::uint32_t corner : triangle) obj += format(" %u/%u/%u", corner + 1, corner + 1, corner + 1);
    obj += '\n';
  }
  write_png(picture, textured.picture);
  write_file(material,
             "newmtl mean_look\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd " + picture.filename().string() + "\n");
  write_file(path, obj);
}

}  // namespace sheen
