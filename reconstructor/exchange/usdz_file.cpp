// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/exchange/usdz_file.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/image/image_io.h"

namespace sheen {
namespace {

constexpr int kJpegQuality = 95;

/// CRC-32 of ISO 3309, as ZIP has it.
std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
  }
  return ~crc;
}

void append(std::string& out, int bytes, std::uint64_t value) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>(value >> 8 * i & 0xff));
}

/// A ZIP archive whose files are stored, each from a multiple of 64 bytes on, as USDZ asks.
class StoredZip {
 public:
  void add(const std::string& name, std::string_view bytes) {
    constexpr std::size_t kAlignment = 64, kHeader = 30, kExtraHeader = 4;
    const std::size_t begin = out_.size(), least = begin + kHeader + name.size() + kExtraHeader;
    const std::size_t padding = (kAlignment - least % kAlignment) % kAlignment;
    std::string common;     // of both headers
    append(common, 2, 20);  // version that can read it
    append(common, 2, 0);
    append(common, 2, 0);  // stored
    append(common, 2, 0);
    append(common, 2, 0x21);  // 1 January 1980: the same model gives the same bytes
    append(common, 4, crc32(bytes));
    append(common, 4, bytes.size());
    append(common, 4, bytes.size());
    append(common, 2, name.size());

    append(out_, 4, 0x04034b50);
    out_ += common;
    append(out_, 2, kExtraHeader + padding);
    out_ += name;
    append(out_, 2, 0x1986);  // a kind of extra field that readers pass over
    append(out_, 2, padding);
    out_.append(padding, '\0');
    out_ += bytes;

    append(directory_, 4, 0x02014b50);
    append(directory_, 2, 20);
    directory_ += common;
    directory_.append(12, '\0');  // no extra field, no comment, first disk, no attributes
    append(directory_, 4, begin);
    directory_ += name;
    ++count_;
  }
  std::string finished() const {
    std::string out = out_ + directory_;
    append(out, 4, 0x06054b50);
    append(out, 4, 0);
    append(out, 2, count_);
    append(out, 2, count_);
    append(out, 4, directory_.size());
    append(out, 4, out_.size());
    append(out, 2, 0);
    return out;
  }

 private:
  std::string out_, directory_;
  std::uint64_t count_ = 0;
};

std::string tuple(const Eigen::Vector3f& v) {
  return format("(%.9g, %.9g, %.9g)", static_cast<double>(v.x()), static_cast<double>(v.y()),
                static_cast<double>(v.z()));
}

/// "[a, b, ...]" of what `word` makes of each.
template <typename T, typename Word>
std::string list(const std::vector<T>& values, const Word& word) {
  std::string out = "[";
  for (const T& value : values) out += (out.size() > 1 ? ", " : "") + word(value);
  return out + "]";
}

constexpr const char* kMaterial = R"(
    def Material "Look"
    {
        token outputs:surface.connect = </Object/Look/Surface.outputs:surface>

        def Shader "Surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0, 0, 0)
            color3f inputs:emissiveColor.connect = </Object/Look/Picture.outputs:rgb>
            float inputs:ior = 1
            float inputs:metallic = 0
            float inputs:roughness = 1
            token outputs:surface
        }

        def Shader "Picture"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @picture.jpg@
            token inputs:sourceColorSpace = "sRGB"
            float2 inputs:st.connect = </Object/Look/Place.outputs:result>
            token inputs:wrapS = "clamp"
            token inputs:wrapT = "clamp"
            float3 outputs:rgb
        }

        def Shader "Place"
        {
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 outputs:result
        }
    }
)";

std::string scene_of(const TexturedMesh& textured, const Eigen::Matrix3f& turn) {
  std::vector<Eigen::Vector3f> points, normals;
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : textured.mesh.vertices) {
    points.emplace_back(turn * vertex);
    box.extend(points.back());
  }
  for (const Eigen::Vector3f& normal : textured.normals) normals.emplace_back((turn * normal).normalized());
  const auto& triangles = textured.mesh.triangles;
  const auto corners = [](const Triangle& t) {
    return std::to_string(t[0]) + ", " + std::to_string(t[1]) + ", " + std::to_string(t[2]);
  };
  const auto place = [](const Eigen::Vector2f& p) {  // upwards from the lower left corner
    return format("(%.9g, %.9g)", static_cast<double>(p.x()), 1 - static_cast<double>(p.y()));
  };
  return "#usda 1.0\n(\n    defaultPrim = \"Object\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n"
         "def Xform \"Object\" (\n    kind = \"component\"\n)\n{\n"
         "    def Mesh \"Mesh\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {\n"
         "        uniform token subdivisionScheme = \"none\"\n"
         "        float3[] extent = [" +
         tuple(box.min()) + ", " + tuple(box.max()) +
         "]\n        int[] faceVertexCounts = " + list(triangles, [](const Triangle&) { return std::string("3"); }) +
         "\n        int[] faceVertexIndices = " + list(triangles, corners) +
         "\n        point3f[] points = " + list(points, tuple) +
         "\n        normal3f[] normals = " + list(normals, tuple) +
         " (\n            interpolation = \"vertex\"\n        )\n        texCoord2f[] primvars:st = " +
         list(textured.place, place) +
         " (\n            interpolation = \"vertex\"\n        )\n        rel material:binding = </Object/Look>\n    "
         "}\n" +
         kMaterial + "}\n";
}

}  // namespace

void write_usdz(const std::filesystem::path& path, const TexturedMesh& textured, const Eigen::Matrix3f& turn) {
  if (textured.picture.width() > kMostUsdzSide)
    throw FileError(path.string(),
                    "cannot be written: its picture has more than " + std::to_string(kMostUsdzSide) + " texels a side");
  const std::vector<std::uint8_t> jpeg = encode_jpeg(textured.picture, kJpegQuality);
  StoredZip zip;
  zip.add("scene.usda", scene_of(textured, turn));  // the first file is the scene
  zip.add("picture.jpg", {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
  write_file(path, zip.finished());
}

}  // namespace sheen
