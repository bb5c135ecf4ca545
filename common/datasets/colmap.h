// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"

namespace sheen {

/// One line of COLMAP's images file, as it stands there.
struct ColmapImage {
  std::string name;
  std::uint32_t camera_id = 0;
  Eigen::Vector4d rotation_wxyz;  ///< camera from world
  Eigen::Vector3d translation;
};

/// Beside the images file: the names of the images that are held out, a line each. All others are for training.
inline constexpr const char* kColmapHeldOut = "test.txt";

using ColmapCameras = std::map<std::uint32_t, Camera>;

/// Contents of `cameras.txt` / `images.txt` and of their binary twins. `file` names the file in errors. Throw
/// FileError.
ColmapCameras parse_colmap_cameras_text(const std::string& file, std::string_view text);
ColmapCameras parse_colmap_cameras_binary(const std::string& file, std::string_view bytes);
std::vector<ColmapImage> parse_colmap_images_text(const std::string& file, std::string_view text);
std::vector<ColmapImage> parse_colmap_images_binary(const std::string& file, std::string_view bytes);

/// A camera of COLMAP's numbered models (`model_id`), first pixel centre at (0, 0). Throws Error with the reason.
Camera colmap_camera(int model_id, double width, double height, const std::vector<double>& parameters);
/// The same the other way round, in the simplest model that holds the lens.
struct ColmapParameters {
  std::string model;
  std::vector<double> values;
};
ColmapParameters colmap_parameters(const Camera& camera);
/// Parameters that a model has; -1 for a model that is not supported.
int colmap_parameter_count(int model_id);
/// -1 when unknown.
int colmap_model_id(std::string_view name);

/// Throws Error when the quaternion is not a rotation or the camera is beyond `kLongestLength`.
Rigid3 colmap_pose(const ColmapImage& image);

}  // namespace sheen
