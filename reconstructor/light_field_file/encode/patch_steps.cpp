// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/patch_steps.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

// Weights as they follow from the squares of errors (a half) spread the steps further than the pictures bear out.
constexpr double kStrength = 0.3;  // octaves of a step for one of pixels
constexpr long kMost = 6;          // quarter octaves

/// Pixels that a triangle covers in an image, wherever it faces the camera.
double pixels(const Mesh& mesh, std::size_t triangle, const PosedCamera& posed, const Eigen::Vector3d& centre) {
  const Eigen::Vector3d a = mesh.corner(triangle, 0).cast<double>(), b = mesh.corner(triangle, 1).cast<double>(),
                        c = mesh.corner(triangle, 2).cast<double>();
  const Eigen::Vector3d to_camera = centre - (a + b + c) / 3;
  const double facing = (b - a).cross(c - a).dot(to_camera) / 2, distance = to_camera.norm();
  return facing > 0 ? facing * posed.camera.fx * posed.camera.fy / (distance * distance * distance) : 0;
}

}  // namespace

std::vector<std::int8_t> choose_patch_steps(const CompactModel& model, const ForEach& for_each) {
  std::vector<Eigen::Vector3d> centres;
  for (const PosedCamera& camera : model.cameras) centres.push_back(camera_centre(camera.camera_from_object));
  const std::vector<PatchShape>& shapes = model.shapes.patches;
  std::vector<double> octaves(shapes.size());  // of pixels per sample; not a number where no image shows any
  for_each(shapes.size(), [&](std::size_t p) {
    double sum = 0;
    for (const std::uint16_t image : patch_images(model, shapes[p]))
      for (const std::uint32_t triangle : shapes[p].triangles)
        sum += pixels(*model.mesh, triangle, model.cameras[image], centres[image]);
    octaves[p] = sum > 0 ? std::log2(sum / shapes[p].samples) : NAN;
  });
  double mean = 0, samples = 0;
  for (std::size_t p = 0; p < shapes.size(); ++p)
    if (std::isfinite(octaves[p])) {
      mean += octaves[p] * shapes[p].samples;
      samples += shapes[p].samples;
    }
  std::vector<std::int8_t> steps(shapes.size());
  std::int8_t last = 0;
  for (std::size_t p = 0; p < shapes.size(); ++p) {
    if (std::isfinite(octaves[p]))
      last = static_cast<std::int8_t>(
          std::clamp<long>(std::lround(4 * kStrength * (mean / samples - octaves[p])), -kMost, kMost));
    steps[p] = last;
  }
  return steps;
}

}  // namespace sheen
