// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/exchange/textured_mesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "common/image/color.h"
#include "reconstructor/exchange/texture_atlas.h"

namespace sheen {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr int kLeastSide = 256;
constexpr float kUsed = 0.7f;    ///< of a texture, by triangles
constexpr float kBorder = 1.5f;  ///< texels round a triangle that show its edge
constexpr std::uint32_t kNone = ~0u;

Vector2f centre_of(int x, int y) {
  return {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
}

int side_for(std::size_t texels, int most_side) {
  int side = kLeastSide;
  while (side < most_side && kUsed * static_cast<float>(side) * static_cast<float>(side) < static_cast<float>(texels))
    side *= 2;
  return std::min(side, most_side);
}

/// What a texel shows.
struct Texel {
  std::uint32_t triangle = kNone;
  float u = 0, v = 0;   ///< barycentric weights of corners 1 and 2
  float off = kBorder;  ///< texels from its centre to the triangle
};

/// Of each texel the nearest triangle, where one is nearer than `kBorder`.
std::vector<Texel> texels_of(const TextureAtlas& atlas) {
  std::vector<Texel> texels(static_cast<std::size_t>(atlas.side) * atlas.side);
  for (std::uint32_t t = 0; t < atlas.triangles.size(); ++t) {
    const FlatTriangle& flat = atlas.triangles[t];
    flat.for_each_pixel(atlas.side, atlas.side, kBorder, [&](int x, int y, const Vector3f& weights) {
      Texel& texel = texels[static_cast<std::size_t>(y) * atlas.side + x];
      if (texel.off == 0) return;
      const Vector3f within = weights.cwiseMax(0.0f) / weights.cwiseMax(0.0f).sum();
      const Vector2f nearest = within[0] * flat.corners[0] + within[1] * flat.corners[1] + within[2] * flat.corners[2];
      const float off = weights.minCoeff() >= 0 ? 0.0f : (nearest - centre_of(x, y)).norm();
      if (off < texel.off) texel = {t, within[1], within[2], off};  // false where the triangle has no area
    });
  }
  return texels;
}

/// Colours the pixels round those that have one with the mean of these, so many pixels wide; all others with the mean
/// of all. Filters then mix nothing in that is not there.
void fill_round(ImageU8& picture, std::vector<bool>& coloured, int pixels) {
  const int side = picture.width();
  const auto at = [side](int x, int y) { return static_cast<std::size_t>(y) * side + x; };
  std::array<std::uint64_t, 3> sum{};
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < coloured.size(); ++i) {
    if (!coloured[i]) continue;
    for (int c = 0; c < 3; ++c) sum[c] += picture.data()[3 * i + c];
    ++count;
  }
  for (int ring = 0; ring < pixels; ++ring) {
    std::vector<std::size_t> now;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        if (coloured[at(x, y)]) continue;
        std::array<int, 3> mean{};
        int beside = 0;
        for (int j = std::max(0, y - 1); j <= std::min(side - 1, y + 1); ++j)
          for (int i = std::max(0, x - 1); i <= std::min(side - 1, x + 1); ++i) {
            if (!coloured[at(i, j)]) continue;
            ++beside;
            for (int c = 0; c < 3; ++c) mean[c] += picture.at(i, j, c);
          }
        if (beside == 0) continue;
        for (int c = 0; c < 3; ++c) picture.at(x, y, c) = static_cast<std::uint8_t>((mean[c] + beside / 2) / beside);
        now.push_back(at(x, y));
      }
    for (const std::size_t i : now) coloured[i] = true;
  }
  for (std::size_t i = 0; i < coloured.size() && count > 0; ++i)
    if (!coloured[i])
      for (int c = 0; c < 3; ++c) picture.data()[3 * i + c] = static_cast<std::uint8_t>(sum[c] / count);
}

ImageU8 painted(const TextureAtlas& atlas, const ViewShader& look) {
  const std::vector<Texel> texels = texels_of(atlas);
  ImageU8 picture(atlas.side, atlas.side, 3);
  std::vector<bool> coloured(texels.size());
  for (std::size_t i = 0; i < texels.size(); ++i) coloured[i] = texels[i].triangle != kNone;
  tbb::parallel_for(0, atlas.side, [&](int y) {
    for (int x = 0; x < atlas.side; ++x) {
      const Texel& texel = texels[static_cast<std::size_t>(y) * atlas.side + x];
      if (texel.triangle == kNone) continue;
      const Vector3f rgb = look.shade(texel.triangle, texel.u, texel.v).rgb;
      to_srgb8({rgb.data(), 3}, picture.pixel(x, y));
    }
  });
  fill_round(picture, coloured, kGutter);
  return picture;
}

}  // namespace

TexturedMesh textured_mesh(const Mesh& mesh, const AverageLook& look, int most_side) {
  const TextureAtlas atlas = texture_atlas(mesh, side_for(look.samples, most_side));
  const std::vector<Vector3f> normals = vertex_normals(mesh);
  TexturedMesh textured{.mesh = {.vertices = {}, .triangles = mesh.triangles, .origin = mesh.origin},
                        .normals = {},
                        .place = {},
                        .picture = painted(atlas, *look.shader)};
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> copies;  // of a vertex in a chart
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t vertex = mesh.triangles[t][c];
      const auto [copy, is_new] =
          copies.try_emplace({vertex, atlas.chart[t]}, static_cast<std::uint32_t>(textured.mesh.vertices.size()));
      if (is_new) {
        textured.mesh.vertices.push_back(mesh.vertices[vertex]);
        textured.normals.push_back(normals[vertex]);
        textured.place.push_back(atlas.triangles[t].corners[c] / static_cast<float>(atlas.side));
      }
      textured.mesh.triangles[t][c] = copy->second;
    }
  return textured;
}

}  // namespace sheen
