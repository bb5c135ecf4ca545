// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "common/geometry/mesh.h"
#include "reconstructor/refinement/refinement_images.h"

namespace sheen {

/// Each turned about the object and shifted across and along the view by chance, by so many pixels or nearly.
inline RefinementImages with_poses_off(RefinementImages images, const BoundingSphere& object, double by_px,
                                       unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
  const Rigid3 from_centre{Eigen::Quaterniond::Identity(), object.centre};
  for (PosedCamera& view : images.cameras) {
    const double metres = by_px / std::sqrt(2.0) / view.camera.fx * (view.camera_from_object * object.centre).norm();
    const Eigen::Vector3d turn = vector() * metres / object.radius, shift = vector() * metres / std::sqrt(2.0);
    const Rigid3 about{Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())), {0, 0, 0}};
    view.camera_from_object = Rigid3{Eigen::Quaterniond::Identity(), shift} * view.camera_from_object * from_centre *
                              about * from_centre.inverse();
  }
  return images;
}

/// How far poses bring the vertices that face them from where they are, pixels, root of the mean square.
inline double apart_px(const Mesh& mesh, const std::vector<PosedCamera>& right, const std::vector<Rigid3>& poses) {
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  double squares = 0, count = 0;
  for (std::size_t i = 0; i < right.size(); ++i)
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const Eigen::Vector3d point = mesh.vertices[v].cast<double>();
      if (normals[v].cast<double>().dot(camera_centre(right[i].camera_from_object) - point) <= 0) continue;
      const auto truth = right[i].camera.project(right[i].camera_from_object * point);
      const auto seen = right[i].camera.project(poses[i] * point);
      if (!truth || !seen) continue;
      squares += (*truth - *seen).squaredNorm();
      ++count;
    }
  return std::sqrt(squares / count);
}

}  // namespace sheen
