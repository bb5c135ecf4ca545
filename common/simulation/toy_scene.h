// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/geometry/mesh.h"

namespace sheen {

/// A still life of simple solids on a ground, of which everything is known in closed form: a ball, a box, a rod that
/// stands upright, a cone, a low disc. Parts are closed; the ground is a square of two triangles, 1.24 m wide, at z =
/// 0.
struct ToyScene {
  enum Part : std::uint8_t { kGround, kBall, kBox, kRod, kCone, kDisc };

  Mesh mesh;                             ///< metres; z is up
  std::vector<Eigen::Vector3f> normals;  ///< unit, per corner of each triangle, of the solid behind it
  std::vector<std::uint8_t> parts;       ///< per triangle
  float gloss = 0;                       ///< height of a Blinn-Phong lobe on ball, cone and disc; 0: all is matt

  /// Diffuse reflectance, 0..1: smooth noise and soft-edged stripes, finer on the ground.
  Eigen::Array3f albedo(std::uint8_t part, const Eigen::Vector3f& position) const;
};

ToyScene make_toy_scene(float gloss);

/// What the rod is: a cylinder from the ground upwards.
inline constexpr float kRodRadius = 0.008f, kRodHeight = 0.14f;
inline const Eigen::Vector2f kRodPlace{0.0f, -0.07f};

}  // namespace sheen
