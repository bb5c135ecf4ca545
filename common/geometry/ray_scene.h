// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>

#include "common/geometry/mesh.h"

namespace sheen {

inline constexpr std::uint32_t kNoHit = 0xffffffffu;

struct Ray {
  Eigen::Vector3f origin;
  Eigen::Vector3f direction;  ///< need not be unit; distances are in multiples of it
  float near = 0;
  float far = 1e30f;
};

struct Hit {
  std::uint32_t triangle = kNoHit;
  float distance = 0;  ///< in multiples of the ray's direction
  float u = 0, v = 0;  ///< barycentric weights of corners 1 and 2
  bool front = false;  ///< the side from which the triangle runs counter-clockwise
  explicit operator bool() const { return triangle != kNoHit; }
};

/// Ray queries against one mesh; the only user of Embree. Watertight along edges (RTC_SCENE_FLAG_ROBUST); of rays
/// aimed exactly at a vertex, three in a thousand slip through. Queries are const and thread-safe; the mesh is copied.
class RayScene {
 public:
  explicit RayScene(const Mesh& mesh);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  Hit intersect(const Ray& ray) const;
  bool occluded(const Ray& ray) const;
  /// Many coherent rays at once (packets): `hits[i]` belongs to `rays[i]`.
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const;
  void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const;  ///< 1 or 0 for each ray

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
