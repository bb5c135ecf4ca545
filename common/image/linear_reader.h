// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "common/image/image.h"
#include "common/image/photometry.h"
#include "common/image/raw_image.h"

namespace sheen {

/// Reads a raw image as linear radiance, part by part: `to_linear_rgb` says what the values are.
/// The image must be valid (`validation_error`) and outlive the reader.
/// Const members are thread-safe.
class LinearReader {
 public:
  explicit LinearReader(const RawImage& image, float black_level = 0, const float white_balance[3] = nullptr);
  /// By what was measured of the camera; floating-point values are light already, of which only the vignette and the
  /// balance are taken. `photometry` must be valid and outlive the reader.
  LinearReader(const RawImage& image, const Photometry& photometry);

  /// Writes the pixels of `box`, which lies inside the image, row by row: `channels` floats per pixel (3; or 4, the
  /// last of which is 0), rows `stride` floats apart.
  void read(const PixelBox& box, int channels, float* out, std::size_t stride) const;

 private:
  void read_pixels(const PixelBox& box, int channels, float* out, std::size_t stride) const;
  void read_bayer(const PixelBox& box, int channels, float* out, std::size_t stride) const;
  void undo_vignette(const PixelBox& box, int channels, float* out, std::size_t stride) const;

  const RawImage& image_;
  float balance_[3];
  float linear_[256];  ///< of an 8-bit value; of a mosaic's site as `demosaic` takes it
  const Vignette* vignette_ = nullptr;
};

/// Linear RGB radiance, 3 channels, 1.0 = white level. Bayer is interpolated by `demosaic`,
/// `black_level` (0..1 of full scale) subtracted and the rest rescaled, each channel multiplied by its white balance.
ImageF to_linear_rgb(const RawImage& image, float black_level = 0, const float white_balance[3] = nullptr);

/// 8-bit grey for looking at and for finding tags; Bayer sites are used as they are, with no demosaicing.
ImageU8 to_grey8(const RawImage& image);

}  // namespace sheen
