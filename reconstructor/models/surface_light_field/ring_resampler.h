// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/image.h"
#include "reconstructor/surface/ring_visibility.h"

namespace sheen {

/// An image ready to be sampled: linear radiance, with coarser levels where the image is finer than the surface maps.
class RadianceImage {
 public:
  /// `linear`: 3 channels. Pixels that are not finite are marked in `valid()` and read as 0.
  explicit RadianceImage(const ImageF& linear);

  /// Linear RGB at a place, prefiltered for samples `step_px` apart: cubic convolution (a = -0.6) on the full image,
  /// linear interpolation on the coarser levels, which are box-filtered by two each.
  Eigen::Vector3f sample(const Eigen::Vector2f& pixel, float step_px) const;

  /// 1 channel, 0 where the pixel is NaN or infinite; empty when all are finite.
  const ImageU8& valid() const { return valid_; }

 private:
  std::vector<ImageF> levels_;  ///< 4 channels, the last is unused: a pixel is one vector register
  ImageU8 valid_;
};

/// The colours that an image gives to the surface samples it shows, interpolated as linear radiance, divided by `gain`
/// and encoded (`srgb_encode`): 3 x samples. Columns of samples that are not visible are left as they were.
void resample(const RadianceImage& image, const SurfaceView& view, const VertexRings& rings, float gain,
              Eigen::Matrix3Xf& encoded);

}  // namespace sheen
