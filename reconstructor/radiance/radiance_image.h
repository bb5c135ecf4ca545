// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "common/capture/capture.h"
#include "common/image/image.h"
#include "reconstructor/surface/sample_visibility.h"

namespace sheen {

/// How an image is read between its pixels.
enum class Sampling {
  kCubic,   ///< cubic convolution (a = -0.6): sharp
  kLinear,  ///< linear interpolation: a quarter of the reads, blurs
};

/// An image ready to be sampled: linear radiance, with coarser levels where the image is finer than the surface maps.
class RadianceImage {
 public:
  RadianceImage() = default;
  /// `linear`: 3 channels.
  explicit RadianceImage(const ImageF& linear);

  /// Takes what the samples of `view`, a view of this capture, will read; nothing else of the image is decoded. Beyond
  /// its edges the surface is continued (`fill_edges`); other pixels that are not finite read as 0. Storage is reused.
  /// Where `view` allows a sample, nothing but the surface that its pixel shows is read.
  void load(const Capture& capture, const SurfaceView& view);

  /// Linear RGB at a place of the image, prefiltered for samples `step_px` apart: `sampling` of the full image, linear
  /// interpolation on the coarser levels, which are box-filtered by two each. Beside an edge, where a kernel or a
  /// coarser level would read another surface: linear interpolation on the coarsest level that does not.
  Eigen::Vector3f sample(const Eigen::Vector2f& pixel, float step_px, Sampling sampling = Sampling::kCubic) const;
  /// The same of those places that are `wanted`, one after the other. `rgb`: three values each, and one more float at
  /// the end, which is overwritten.
  void sample(std::span<const float> pixel_x, std::span<const float> pixel_y, std::span<const std::uint8_t> wanted,
              float step_px, Sampling sampling, float* rgb) const;

 private:
  void fill_coarser_levels(float largest_step_px);

  int levels_used_ = 0;
  std::array<ImageF, 4> levels_;  ///< 4 channels, a pixel is one vector register; the last: what may be read
  Eigen::Vector2f origin_{0, 0};  ///< pixel of the image at (0, 0) of the first level
};

/// The capture's mask without the pixels that are NaN or infinite; empty when all pixels are good.
ImageU8 usable_pixels(const Capture& capture);

/// The capture's linear radiance, RGB, divided by `gain`.
ImageF level_radiance(const Capture& capture, float gain);
/// The capture with such floats for its image, and an exposure that is so much less where it is known.
Capture levelled(Capture capture, float gain);

}  // namespace sheen
