// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "common/camera/camera.h"
#include "common/image/photometry.h"

namespace sheen {

/// What a camera makes of light, with standard deviations of what was measured of it.
struct PhotometricCalibration {
  Photometry photometry;
  std::string response;    ///< the model that explained it: "linear", "srgb", "gamma" or "curve"
  double gamma = 1;        ///< of a "gamma" response
  double black_level = 0;  ///< stored value without light, of full scale
  double black_level_uncertainty = 0;
  /// Of `photometry.response`, each relative to the light of `reference_value`.
  std::array<float, 256> response_uncertainty{};
  double reference_value = 1;  ///< of full scale
  /// Of the vignette, relative, greatest over the image and of its centre in pixels. Empty: no vignette was measured.
  struct VignetteUncertainty {
    double worst = 0;
    double centre_px = 0;
  };
  std::optional<VignetteUncertainty> vignette;
  /// Of the balance, relative. Empty: it was not measured.
  std::optional<std::array<double, 3>> white_balance;
};

/// A camera as `sheen-tracker calibrate` writes it and a rig's `[camera] file` reads it.
struct CameraFile {
  Camera camera;
  double focal_uncertainty = 0;  ///< standard deviation of the focal length as a part of it; 0: not known
  std::optional<PhotometricCalibration> photometric{};  ///< empty: nobody measured what the camera makes of light
};

/// JSON; throws FileError naming the field.
CameraFile load_camera(const std::filesystem::path& path);
void save_camera(const CameraFile& file, const std::filesystem::path& path);

/// "opencv" or "fisheye", as files name a lens.
const char* lens_name(LensModel lens);
/// A camera as its file and the reports have it: the keys of `[camera]` of a rig.
nlohmann::json camera_json(const Camera& camera);

}  // namespace sheen
