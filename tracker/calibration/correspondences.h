// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sheen {

/// Where an image shows a point.
struct PickedPixel {
  std::string image;  ///< `name` of its capture, or its file name
  Eigen::Vector2d pixel;
};

/// A point of the mesh that a person found again on the stage or in images.
struct PickedPoint {
  std::string name;
  Eigen::Vector3d mesh;                  ///< in the mesh file's own numbers
  std::optional<Eigen::Vector3d> stage;  ///< metres
  std::vector<PickedPixel> pixels;       ///< where `stage` is empty
};

struct Correspondences {
  std::vector<PickedPoint> points;
  /// Standard deviations of a coordinate, where the file says them; else they follow from the residuals.
  std::optional<double> stage_uncertainty_m, pixel_uncertainty_px;
};

/// Reads a file of picked points (the user guide shows one). Throws FileError naming the field.
Correspondences load_correspondences(const std::filesystem::path& path);

}  // namespace sheen
