// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "common/image/image.h"
#include "common/image/raw_image.h"
#include "common/simulation/sensor.h"

namespace sheen {

/// What lies between the light of a scene and the values that a camera stores.
struct SensorResponse {
  double focal_px = 0;    ///< natural vignetting: light falls with the fourth power of the cosine; 0 = none
  double cx = 0, cy = 0;  ///< where the lens looks straight ahead, pixels
  std::array<double, 3> tint{1, 1, 1};  ///< what a grey surface shows of red, green and blue
  double black = 0;                     ///< light that the sensor reports without any, of full scale
  double gamma = 1;                     ///< a stored value is the power 1/gamma of what the sensor reports
  double saturation = 1;                ///< stored value that none exceeds
  SensorNoise noise;

  /// Light that the lens lets through to a pixel, 1 at (cx, cy): the truth that a calibration is held against.
  double vignette(double x, double y) const;
  /// Stored value, unrounded and without noise, of light that reaches the sensor.
  double stored(double light) const;
};

/// The stored values of full scale 1, rounded to `levels` steps (255, 4095): `radiance` times `exposure` through lens,
/// sensor and response. 1 or 3 channels.
ImageF stored_values(const ImageF& radiance, double exposure, const SensorResponse& response, int levels,
                     std::uint64_t seed);

/// The same as an image of 8 bits with three channels.
RawImage stored_rgb8(const ImageF& radiance, double exposure, const SensorResponse& response, std::uint64_t seed);

}  // namespace sheen
