// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "common/camera/camera.h"
#include "reconstructor/models/surface_light_field/surface_light_field.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/test_meshes.h"

namespace sheen {

/// 160 x 120 pixels; its lens is as long as it takes for 0.2 m round the origin to fill 100 of them.
inline Camera camera_at(const Eigen::Vector3d& eye) {
  const double f = 500 * eye.norm();
  return {.width = 160, .height = 120, .fx = f, .fy = f, .cx = 79.5, .cy = 59.5};
}

/// A square or sphere as the model's mesh and as the pictures' surface.
struct Object {
  std::shared_ptr<const Mesh> mesh;
  analytic::Surface surface;
};
inline Object square_object() {
  return {std::make_shared<Mesh>(square_mesh(0.1f, 0, 8)), analytic::square(0.1, 0)};
}
inline Object sphere_object() {
  return {std::make_shared<Mesh>(sphere_mesh(0.09f, 3)), analytic::sphere(0.09)};
}

/// All images are for learning and of one exposure.
inline SurfaceLightFieldOptions plain_options() {
  SurfaceLightFieldOptions options;
  options.hold_out_every = 0;
  return options;
}

/// Between the eyes that lie 0.5 from the origin and 0.55 of that above it at least.
inline std::vector<Eigen::Vector3d> unseen_eyes() {
  return analytic::eyes(5, 0.5, 0.63, 0.95);
}

inline std::vector<Capture> captures(const analytic::Scene& scene, const std::vector<Eigen::Vector3d>& eyes) {
  std::vector<Capture> result;
  for (const Eigen::Vector3d& eye : eyes) {
    result.push_back(analytic::capture(scene, camera_at(eye), analytic::towards_origin(eye)));
    result.back().sequence = result.size();
  }
  return result;
}

/// Ingests all; fails the test for one that is not accepted.
void ingest_all(SurfaceLightField& model, const std::vector<Capture>& captures);

/// Painted against true picture over the pixels of which the model says that an image showed them, 3 pixels inside the
/// silhouette; differences of encoded values, clamped to 0..1.
struct Comparison {
  double rms = 0;
  double worst = 0;          ///< absolute difference of a channel
  double darkest_ratio = 1;  ///< lowest painted / true value
  std::size_t pixels = 0;    ///< shown by an image
  std::size_t unseen = 0;    ///< in the silhouette, yet shown by none
  double psnr_db() const;
};
Comparison compare(const Appearance& model, const analytic::Scene& scene, const std::vector<Eigen::Vector3d>& eyes);

/// Fails the test for every patch that is not the same to the last bit.
void expect_same_patches(const ModelSnapshot& a, const ModelSnapshot& b);
/// A snapshot that is known to be of a surface light field.
const SurfaceLightFieldSnapshot& light_field(const ModelSnapshot& snapshot);

/// Fraction of the patches that images reached that have at most this rank.
double share_of_rank_up_to(const SurfaceLightField& model, std::size_t rank);

}  // namespace sheen
