// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/procedural_noise.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

std::uint32_t cell_hash(int x, int y, int z) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343u ^ static_cast<std::uint32_t>(y) * 0xd8163841u ^
                    static_cast<std::uint32_t>(z) * 0xcb1ab31fu;
  h = (h ^ (h >> 16)) * 0x7feb352du;
  h = (h ^ (h >> 15)) * 0x846ca68bu;
  return h ^ (h >> 16);
}

/// The twelve edge directions of a cube (Perlin 2002), four of them twice. A table: a hash would mislead branches.
constexpr float kGradients[16][3] = {{1, 1, 0},  {-1, 1, 0},  {1, -1, 0}, {-1, -1, 0}, {1, 0, 1},  {-1, 0, 1},
                                     {1, 0, -1}, {-1, 0, -1}, {0, 1, 1},  {0, -1, 1},  {0, 1, -1}, {0, -1, -1},
                                     {1, 1, 0},  {0, -1, 1},  {-1, 1, 0}, {0, -1, -1}};

float fade(float t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

float mix(float a, float b, float t) {
  return a + (b - a) * t;
}

}  // namespace

std::uint64_t mix_bits(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15ull;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ull;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebull;
  return value ^ (value >> 31);
}

float gradient_noise(const Eigen::Vector3f& p) {
  const float fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy), iz = static_cast<int>(fz);
  const float x = p.x() - fx, y = p.y() - fy, z = p.z() - fz;
  const float u = fade(x), v = fade(y), w = fade(z);
  const auto at = [&](int dx, int dy, int dz) {
    const float* gradient = kGradients[cell_hash(ix + dx, iy + dy, iz + dz) & 15];
    return gradient[0] * (x - float(dx)) + gradient[1] * (y - float(dy)) + gradient[2] * (z - float(dz));
  };
  return mix(mix(mix(at(0, 0, 0), at(1, 0, 0), u), mix(at(0, 1, 0), at(1, 1, 0), u), v),
             mix(mix(at(0, 0, 1), at(1, 0, 1), u), mix(at(0, 1, 1), at(1, 1, 1), u), v), w);
}

float fractal_noise(Eigen::Vector3f p, int octaves) {
  float sum = 0, height = 0.5f;
  for (int i = 0; i < octaves; ++i) {
    sum += height * gradient_noise(p);
    p = 2 * p + Eigen::Vector3f::Constant(17.31f);  // shifted, so that the zeros of the octaves do not meet
    height /= 2;
  }
  return sum;
}

ScatteredPoint nearest_scattered_point(const Eigen::Vector3f& p) {
  const int ix = static_cast<int>(std::floor(p.x())), iy = static_cast<int>(std::floor(p.y())),
            iz = static_cast<int>(std::floor(p.z()));
  float best = 1e9f;
  std::uint32_t name = 0;
  // Own cell first: mostly nothing in the others can be as near.
  const auto away = [](float place, int cell) {
    return std::max({0.0f, static_cast<float>(cell) - place, place - static_cast<float>(cell + 1)});
  };
  for (const int z : {iz, iz - 1, iz + 1}) {
    const float off_z = away(p.z(), z);
    for (const int y : {iy, iy - 1, iy + 1}) {
      const float off_y = away(p.y(), y);
      if (off_z * off_z + off_y * off_y >= best) continue;
      for (const int x : {ix, ix - 1, ix + 1}) {
        const float off_x = away(p.x(), x);
        if (off_z * off_z + off_y * off_y + off_x * off_x >= best) continue;
        const std::uint32_t h = cell_hash(x, y, z);
        const Eigen::Vector3f point(x + (h & 1023) / 1024.0f, y + ((h >> 10) & 1023) / 1024.0f,
                                    z + ((h >> 20) & 1023) / 1024.0f);
        const float squared = (p - point).squaredNorm();
        if (squared < best) best = squared, name = h;
      }
    }
  }
  return {std::sqrt(best), static_cast<float>((name * 0x9e3779b9u) >> 8) * 0x1p-24f};
}

}  // namespace sheen
