// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "tests/common/registration/ellipsoid_photographs.h"

namespace sheen {

/// Of an object that no turn and no mirror takes to itself: an ellipsoid, metres.
struct LopsidedPart {
  Eigen::Vector3d axes, middle;
};
inline const LopsidedPart kParts[] = {{{0.060, 0.045, 0.035}, {0.020, -0.015, 0.030}},
                                      {{0.030, 0.030, 0.030}, {0.075, -0.010, 0.050}},
                                      {{0.022, 0.022, 0.022}, {0.015, 0.035, 0.025}},
                                      {{0.020, 0.020, 0.020}, {0.000, -0.030, 0.070}}};

inline analytic::Scene lopsided() {
  analytic::Surface surface = ellipsoid(kParts[0].axes, kParts[0].middle);
  for (const auto& [axes, middle] : kParts) surface = analytic::nearest_of(surface, ellipsoid(axes, middle));
  return {surface, analytic::diffuse(0.012)};
}

inline Mesh lopsided_mesh() {
  Mesh mesh;
  for (const auto& [axes, middle] : kParts) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const Mesh part = ellipsoid_mesh(axes, middle, 4);
    mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
    for (const Triangle& t : part.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return mesh;
}

/// Three images in turn from each of three sides.
inline std::vector<RegistrationImage> from_three_sides(const analytic::Scene& scene, bool masks) {
  std::vector<RegistrationImage> images;
  for (const double azimuth : {0.0, 2.1, 4.2})
    for (RegistrationImage& image : images_in_turn(scene, masks, 3, azimuth)) images.push_back(std::move(image));
  return images;
}

}  // namespace sheen
