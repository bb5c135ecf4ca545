// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"
#include "tracker/lights/shadow_light.h"

namespace sheen {

/// A point as a person clicked it: its place, or a pixel of the light's image.
struct ClickedPoint {
  std::optional<Eigen::Vector3d> place;  ///< metres
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};
struct ClickedPair {
  ClickedPoint shadow, object;
};
struct ClickedLight {
  std::string image;
  std::vector<ClickedPair> pairs;
};

/// A file of shadows and the points that cast them (the user guide shows one).
struct ShadowFile {
  std::vector<ClickedLight> lights;
  /// Standard deviations of a coordinate; without them the residuals say the noise.
  std::optional<double> uncertainty_m, pixel_uncertainty_px;
  bool any_pixels() const;
};
/// Throws FileError naming the field.
ShadowFile load_shadow_file(const std::filesystem::path& path);

/// The pairs of a light in space. `view` and `mesh`: where it has pixels; a point is where a pixel's ray meets the
/// mesh, and its error slides along the surface. Throws Error that names the pair: a pixel shows no surface.
std::vector<ShadowPair> pairs_in_space(const ClickedLight& light, const ShadowFile& file, const PosedCamera* view,
                                       const Mesh* mesh);

}  // namespace sheen
