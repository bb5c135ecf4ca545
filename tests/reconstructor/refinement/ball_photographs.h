// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "reconstructor/refinement/mesh_refinement.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/test_meshes.h"

namespace sheen {

inline constexpr double kRadius = 0.1, kDistance = 0.5;
inline const Camera kCamera{.width = 240, .height = 200, .fx = 420, .fy = 420, .cx = 119.5, .cy = 99.5};
inline constexpr double kPixel = kDistance / 420;  // on the object, metres

/// Photographs of a textured ball or square from all round (or above), exact but for what a point sample is.
class Photographs {
 public:
  Photographs(const analytic::Scene& scene, int count, double lowest, bool masks) {
    for (const Eigen::Vector3d& eye : analytic::eyes(count, kDistance, lowest)) {
      captures_.push_back(analytic::capture(scene, kCamera, analytic::towards_origin(eye)));
      if (masks) captures_.back().mask = mask(scene, captures_.back());
      images_.cameras.push_back({kCamera, captures_.back().pose.camera_from_object});
    }
    images_.masked = masks;
    images_.read = [this](std::size_t i) { return captures_[i]; };
  }
  Photographs(const Photographs&) = delete;
  Photographs& operator=(const Photographs&) = delete;
  const RefinementImages& images() const { return images_; }

 private:
  static ImageU8 mask(const analytic::Scene& scene, const Capture& capture) {
    const Rigid3 object_from_camera = capture.pose.camera_from_object.inverse();
    ImageU8 mask(kCamera.width, kCamera.height, 1);
    for (int y = 0; y < kCamera.height; ++y)
      for (int x = 0; x < kCamera.width; ++x) {
        const Eigen::Vector3d ray = object_from_camera.rotation * *kCamera.ray({double(x), double(y)});
        mask.at(x, y) = scene.surface(object_from_camera.translation, ray) < analytic::kMiss ? 255 : 0;
      }
    return mask;
  }
  std::vector<Capture> captures_;
  RefinementImages images_;
};

inline analytic::Scene ball() {
  return {analytic::sphere(kRadius), analytic::diffuse(0.02)};
}

/// Of the vertices' distances from the ball's surface, metres.
inline double rms_from_ball(const Mesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3f& v : mesh.vertices) sum += std::pow(v.norm() - kRadius, 2);
  return std::sqrt(sum / static_cast<double>(mesh.vertices.size()));
}

/// A ball whose surface waves by this much RMS, metres.
inline Mesh waved_ball(double rms) {
  Mesh mesh = sphere_mesh(kRadius, 4);
  for (Eigen::Vector3f& v : mesh.vertices) {
    const Eigen::Vector3d p = v.cast<double>();
    const double wave = 2 / std::sqrt(3.0) * std::sqrt(2.0) *
                        (std::sin(40 * p.x() + 1) * std::cos(40 * p.y()) + 0.5 * std::sin(50 * p.z()));
    v *= static_cast<float>(1 + rms * wave / kRadius);
  }
  return mesh;
}

}  // namespace sheen
