// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/capture/capture.h"
#include "common/geometry/mesh.h"
#include "common/simulation/test_object.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

/// The demo's object under one directional light: quick to photograph, as textured and as glossy as the path-traced
/// one.
class LitObject {
 public:
  explicit LitObject(const TestObject& object);
  /// The same on another mesh of that surface.
  LitObject(const TestObject& object, const Mesh& mesh);

  const Mesh& mesh() const { return mesh_; }
  /// What a Bayer camera of 8 bits sees, with its noise, which `number` seeds.
  Capture photograph(const Camera& camera, const Rigid3& camera_from_object, std::uint64_t number) const;

 private:
  ImageF draw(const Camera& camera, const Rigid3& camera_from_object) const;

  Mesh mesh_;
  std::vector<Eigen::Vector3f> normals_;  ///< per vertex
  std::function<Material(const Eigen::Vector3f&)> material_;
  RayPainter painter_;
};

}  // namespace sheen
