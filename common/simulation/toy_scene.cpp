// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/toy_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "common/simulation/procedural_noise.h"
#include "common/simulation/texture.h"

namespace sheen {
namespace {

using Eigen::Array3f;
using Eigen::Vector3f;

constexpr float kGroundSide = 1.24f;
constexpr int kSlices = 96;  // round a solid of revolution

/// The number of a vertex at this place; a new one where there is none.
std::uint32_t vertex_at(ToyScene& scene, const Vector3f& place) {
  auto& vertices = scene.mesh.vertices;
  const auto index = static_cast<std::uint32_t>(std::find(vertices.begin(), vertices.end(), place) - vertices.begin());
  if (index == vertices.size()) vertices.push_back(place);
  return index;
}

void add_triangle(ToyScene& scene, std::uint8_t part, const std::array<Vector3f, 3>& corners,
                  const std::array<Vector3f, 3>& normals) {
  if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) return;
  scene.mesh.triangles.push_back(
      {vertex_at(scene, corners[0]), vertex_at(scene, corners[1]), vertex_at(scene, corners[2])});
  scene.normals.insert(scene.normals.end(), normals.begin(), normals.end());
  scene.parts.push_back(part);
}

/// Corners run counter-clockwise seen from where the normal points to.
void add_flat(ToyScene& scene, std::uint8_t part, const std::vector<Vector3f>& corners) {
  const Vector3f normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  for (std::size_t c = 2; c < corners.size(); ++c)
    add_triangle(scene, part, {corners[0], corners[c - 1], corners[c]}, {normal, normal, normal});
}

/// A surface of revolution round the upright through `foot`: radius and height by a parameter in [0, 1], outward normal
/// as (radial, up).
struct Profile {
  std::function<Eigen::Vector2f(float)> place, normal;
  int steps = 1;
};
void add_turned(ToyScene& scene, std::uint8_t part, const Vector3f& foot, const Profile& profile) {
  const auto at = [&](int slice, const Eigen::Vector2f& p) {
    const float azimuth = 2 * float(M_PI) * float(slice % kSlices) / kSlices;
    return Vector3f(p.x() * std::cos(azimuth), p.x() * std::sin(azimuth), p.y());
  };
  for (int s = 0; s < profile.steps; ++s) {
    const float low = float(s) / float(profile.steps), high = float(s + 1) / float(profile.steps);
    for (int k = 0; k < kSlices; ++k) {
      const auto corner = [&](int slice, float t) { return Vector3f(foot + at(slice, profile.place(t))); };
      const auto normal = [&](int slice, float t) { return at(slice, profile.normal(t)).normalized(); };
      add_triangle(scene, part, {corner(k, low), corner(k + 1, low), corner(k + 1, high)},
                   {normal(k, low), normal(k + 1, low), normal(k + 1, high)});
      add_triangle(scene, part, {corner(k, low), corner(k + 1, high), corner(k, high)},
                   {normal(k, low), normal(k + 1, high), normal(k, high)});
    }
  }
}

/// 0 at the poles, where the cosine is not.
float rounded_cosine(float angle) {
  const float cosine = std::cos(angle);
  return std::abs(cosine) < 1e-6f ? 0 : cosine;
}

void add_ball(ToyScene& scene, const Vector3f& centre, float radius) {
  const auto angle = [](float t) { return float(M_PI) * (t - 0.5f); };
  add_turned(scene, ToyScene::kBall, centre,
             {[=](float t) { return Eigen::Vector2f(radius * rounded_cosine(angle(t)), radius * std::sin(angle(t))); },
              [=](float t) { return Eigen::Vector2f(std::cos(angle(t)), std::sin(angle(t))); }, 48});
}

void add_cylinder(ToyScene& scene, std::uint8_t part, const Vector3f& foot, float radius, float height) {
  add_turned(
      scene, part, foot,
      {[=](float t) { return Eigen::Vector2f(radius, height * t); }, [](float) { return Eigen::Vector2f(1, 0); }, 1});
  add_turned(
      scene, part, foot + Vector3f(0, 0, height),
      {[=](float t) { return Eigen::Vector2f(radius * (1 - t), 0); }, [](float) { return Eigen::Vector2f(0, 1); }, 1});
}

void add_cone(ToyScene& scene, const Vector3f& foot, float radius, float height) {
  add_turned(scene, ToyScene::kCone, foot,
             {[=](float t) { return Eigen::Vector2f(radius * (1 - t), height * t); },
              [=](float) { return Eigen::Vector2f(height, radius); }, 1});
}

void add_box(ToyScene& scene, const Vector3f& foot, const Vector3f& half, float azimuth) {
  const Eigen::Matrix3f rotation = Eigen::AngleAxisf(azimuth, Vector3f::UnitZ()).toRotationMatrix();
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      if (axis == 2 && side < 0) continue;  // it stands on the ground
      const int a = (axis + 1) % 3, b = (axis + 2) % 3;
      std::vector<Vector3f> corners;
      for (const auto& [u, v] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
        Vector3f p = Vector3f::Zero();
        p[axis] = side * half[axis];
        p[a] = float(u) * half[a] * side;  // a mirrored face runs the other way round
        p[b] = float(v) * half[b];
        corners.push_back(foot + rotation * (p + Vector3f(0, 0, half.z())));
      }
      add_flat(scene, ToyScene::kBox, corners);
    }
}

/// Stripes of width about `period` / 2 with soft edges, 0..1.
float stripes(float x, float period) {
  return smooth_step(-0.35f, 0.35f, std::sin(2 * float(M_PI) * x / period));
}

}  // namespace

Array3f ToyScene::albedo(std::uint8_t part, const Vector3f& p) const {
  const float rough = fractal_noise(p / 0.035f, 2), fine = fractal_noise(p / 0.012f + Vector3f(9, 4, 1), 2);
  switch (part) {
    case kBall:
      return blend(Array3f(0.75f, 0.30f, 0.18f), Array3f(0.80f, 0.70f, 0.45f), stripes(p.z() + 0.4f * p.x(), 0.032f)) *
             (1 + 0.25f * fine);
    case kBox:
      return blend(Array3f(0.25f, 0.42f, 0.62f), Array3f(0.70f, 0.72f, 0.66f),
                   stripes(p.x() + p.y(), 0.05f) * stripes(p.z() + 0.01f, 0.04f)) *
             (1 + 0.2f * rough + 0.2f * fine);
    case kRod:
      return Array3f(0.62f, 0.58f, 0.50f) * (1 + 0.3f * fine);
    case kCone:
      return blend(Array3f(0.35f, 0.60f, 0.28f), Array3f(0.75f, 0.72f, 0.30f), 0.5f + 0.5f * rough) * (1 + 0.2f * fine);
    case kDisc:
      return Array3f(0.70f, 0.62f, 0.60f) * (1 + 0.3f * rough + 0.2f * fine);
    default:
      return blend(Array3f(0.56f, 0.47f, 0.36f), Array3f(0.70f, 0.64f, 0.55f), stripes(p.x() + 0.02f * rough, 0.09f)) *
             (1 + 0.22f * rough + 0.22f * fine);
  }
}

ToyScene make_toy_scene(float gloss) {
  ToyScene scene;
  scene.gloss = gloss;
  const float g = kGroundSide / 2;
  add_flat(scene, ToyScene::kGround, {{-g, -g, 0}, {g, -g, 0}, {g, g, 0}, {-g, g, 0}});
  add_ball(scene, {-0.12f, 0.01f, 0.05f}, 0.05f);
  add_box(scene, {0.11f, 0.05f, 0}, {0.035f, 0.045f, 0.05f}, 0.5f);
  add_cylinder(scene, ToyScene::kRod, {kRodPlace.x(), kRodPlace.y(), 0}, kRodRadius, kRodHeight);
  add_cone(scene, {-0.01f, 0.10f, 0}, 0.04f, 0.11f);
  add_cylinder(scene, ToyScene::kDisc, {0.12f, -0.10f, 0}, 0.05f, 0.02f);
  return scene;
}

}  // namespace sheen
