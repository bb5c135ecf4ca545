// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "common/image/image.h"
#include "common/image/raw_image.h"

namespace sheen {

/// Noise of an 8-bit linear sensor, in grey levels of 255: variance = read^2 + shot * level.
struct SensorNoise {
  double read_sigma = 0.7;
  double shot = 0.0135;  ///< with it the noise is 2 grey levels at white

  double sigma(double level) const;
};

/// Standard deviation of the spot that a good lens and the area of a pixel make of a point, pixels.
inline constexpr double kLensSpotPx = 0.7;

/// What the lens lays on the sensor: the image under a Gaussian spot. Without it a colour filter array would see detail
/// that no real camera passes, and demosaicing alone would cost more than everything else.
ImageF through_lens(const ImageF& radiance, double sigma_px);

/// Samples an image through the colour filter RGGB (BayerRG8): 1 channel, in units of the white level, unclipped.
ImageF mosaic_rggb(const ImageF& radiance);

/// Adds the sensor's noise to an image in units of the white level. The same seed gives the same noise on every
/// machine.
void add_sensor_noise(ImageF& mosaic, const SensorNoise& noise, std::uint64_t seed);

/// Rounds and clips to 8 bits, linear.
RawImage quantize_rggb(const ImageF& mosaic);

}  // namespace sheen
