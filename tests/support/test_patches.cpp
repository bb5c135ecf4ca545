// SPDX-License-Identifier: Apache-2.0
#include "tests/support/test_patches.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using Eigen::Vector3f;

constexpr int kRows = 16;  // samples along a triangle's side
constexpr float kNoise = 0.01f;

struct Lobe {
  float strength;
  float exponent;
};

/// How a patch bends and shines.
struct Surface {
  float bend_rad;             ///< tilt of the normal at radius 1
  std::array<Lobe, 3> lobes;  ///< a light
};

// Strengths are such that the best rank-12 errors are 0.0397 and 0.253.
constexpr Surface kTypical{0.35f, {{{1.616f, 40}, {0.970f, 25}, {0.646f, 90}}}};
constexpr Surface kHard{0.6f, {{{1.566f, 200}, {1.253f, 120}, {0.940f, 400}}}};

Vector3f albedo(const Eigen::Vector2f& at) {
  const auto wave = [&](float x, float y, float phase) { return std::sin(x * at.x() + y * at.y() + phase); };
  const float fine = 0.08f * wave(21, 13, 0.4f) * wave(-9, 25, 1.1f);
  return {0.55f + 0.2f * wave(3, 2, 0) + fine, 0.45f + 0.2f * wave(-2, 4, 1) + fine,
          0.35f + 0.15f * wave(5, -3, 2) + fine};
}

/// Directions of a camera that spirals outwards round the patch.
std::vector<Vector3f> spiral() {
  std::vector<Vector3f> views;
  for (int v = 0; v < kTestPatchViews; ++v) {
    const float fraction = (static_cast<float>(v) + 0.5f) / kTestPatchViews;
    const float polar = std::acos(1 - fraction * (1 - std::cos(75.0f * std::numbers::pi_v<float> / 180)));
    const float azimuth = 2 * std::numbers::pi_v<float> * 9 * std::sqrt(fraction);
    views.emplace_back(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
  }
  return views;
}

}  // namespace

Eigen::Matrix2Xf test_patch_samples() {
  Eigen::Matrix2Xf samples(2, kTestPatchSamples);
  int next = 0;
  for (int t = 0; t < 6; ++t) {
    const auto corner = [&](int i) {
      const float angle = std::numbers::pi_v<float> / 3 * static_cast<float>(i);
      return Eigen::Vector2f(std::cos(angle), std::sin(angle));
    };
    const Eigen::Vector2f a = corner(t), b = corner(t + 1);
    for (int i = 0; i < kRows; ++i)
      for (int j = 0; i + j < kRows; ++j)
        samples.col(next++) = (static_cast<float>(i) * a + static_cast<float>(j) * b) / (kRows - 1);
  }
  return samples;
}

Eigen::MatrixXf test_patch_columns(TestPatch patch) {
  const Surface& surface = patch == TestPatch::kTypical ? kTypical : kHard;
  const std::array<Vector3f, 3> lights{Vector3f(0.4f, -0.3f, 0.87f).normalized(),
                                       Vector3f(-0.6f, 0.1f, 0.8f).normalized(),
                                       Vector3f(0.1f, 0.7f, 0.7f).normalized()};
  const Eigen::Matrix2Xf samples = test_patch_samples();
  const std::vector<Vector3f> views = spiral();
  Eigen::MatrixXf columns(3 * kTestPatchSamples, kTestPatchViews);
  for (int s = 0; s < kTestPatchSamples; ++s) {
    const Eigen::Vector2f at = samples.col(s);
    const Vector3f normal = (Vector3f::UnitZ() + std::tan(surface.bend_rad) * Vector3f(at.x(), at.y(), 0)).normalized();
    float lit = 0.25f;
    for (const Vector3f& light : lights) lit += 0.25f * std::max(0.0f, normal.dot(light));
    const Vector3f diffuse = lit * albedo(at);
    for (int v = 0; v < kTestPatchViews; ++v) {
      float gloss = 0;
      for (std::size_t l = 0; l < lights.size(); ++l) {
        const Vector3f half = (lights[l] + views[v]).normalized();
        gloss += surface.lobes[l].strength * std::pow(std::max(0.0f, normal.dot(half)), surface.lobes[l].exponent);
      }
      columns.block<3, 1>(3 * s, v) = diffuse.array() + gloss;
    }
  }
  const float level = kNoise * columns.norm() / std::sqrt(static_cast<float>(columns.size()));
  return columns + level * gaussian_matrix(3 * kTestPatchSamples, kTestPatchViews, 1);
}

std::vector<std::vector<int>> column_orders(const Eigen::MatrixXf& columns, int shuffled) {
  const Eigen::VectorXf norms = columns.colwise().norm();
  std::vector<int> order(static_cast<std::size_t>(columns.cols()));
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::vector<int>> orders{order};
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return norms[a] < norms[b]; });
  orders.push_back(order);
  std::reverse(order.begin(), order.end());
  orders.push_back(order);
  std::mt19937 engine(1);
  for (int i = 0; i < shuffled; ++i) {
    std::shuffle(order.begin(), order.end(), engine);
    orders.push_back(order);
  }
  return orders;
}

Eigen::Array<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic> occluding_edges(int views, double occluded,
                                                                           std::uint32_t seed) {
  const Eigen::Matrix2Xf samples = test_patch_samples();
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform;
  Eigen::Array<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic> visible =
      Eigen::Array<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic>::Ones(3 * kTestPatchSamples, views);
  for (int v = 0; v < views; ++v) {
    const bool hidden = uniform(engine) < occluded;
    const double angle = 2 * std::numbers::pi * uniform(engine), fraction = 0.2 + 0.6 * uniform(engine);
    if (!hidden) continue;
    const Eigen::VectorXf along =
        samples.transpose() * Eigen::Vector2f(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
    std::vector<float> sorted(along.begin(), along.end());
    const auto edge = sorted.begin() + static_cast<std::ptrdiff_t>(fraction * kTestPatchSamples);
    std::nth_element(sorted.begin(), edge, sorted.end());
    for (int s = 0; s < kTestPatchSamples; ++s)
      if (along[s] < *edge) visible.col(v).segment<3>(3 * s).setZero();
  }
  return visible;
}

}  // namespace sheen
