// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/camera/camera_file.h"
#include "tracker/calibration/response_fit.h"
#include "tracker/calibration/vignette_fit.h"

namespace sheen {

/// Gains that make grey of a grey target, green 1, with their relative standard deviations.
struct BalanceFit {
  std::array<double, 3> gains{1, 1, 1}, uncertainty{};
  int cells = 0;
};

/// Part of an image, pixels; all of it where it is empty.
struct Patch {
  int x = 0, y = 0, width = 0, height = 0;
  bool empty() const { return width <= 0 || height <= 0; }
};

/// From images of a grey target. `vignette` may be null. Throws Error where they have no colours or nothing is usable.
BalanceFit fit_balance(std::span<const CellImage> greys, const Patch& patch, const ResponseFit& response,
                       const VignetteFit* vignette);

/// What was measured of what a camera makes of light.
struct PhotometricStudy {
  std::vector<std::string> names;  ///< of the sweep's images
  ImageSize size;
  ResponseFit response;
  std::optional<VignetteFit> vignette;
  std::optional<BalanceFit> balance;
};

/// As the camera's file keeps it. A vignette that lens and light share is left out.
PhotometricCalibration calibration_of(const PhotometricStudy& study);

/// What a person should doubt or do again.
std::vector<std::string> warnings(const PhotometricStudy& study);

}  // namespace sheen
