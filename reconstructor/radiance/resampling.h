// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "reconstructor/radiance/radiance_image.h"
#include "reconstructor/surface/map_layout.h"
#include "reconstructor/surface/sample_visibility.h"

namespace sheen {

/// An image, and what it shows of the sampled surface.
struct SurfaceImage {
  const RadianceImage& image;
  const SurfaceView& view;
  const MapLayout& maps;
  float gain;  ///< that its colours are divided by
  Sampling sampling;
};

/// The colours that an image gives to the samples of a triangle that it shows, interpolated as linear radiance, divided
/// by the gain and encoded (`srgb_encode`): 3 x samples of the triangle. Columns of samples that are not visible are
/// left as they were.
void resample(const SurfaceImage& from, std::size_t triangle, Eigen::Ref<Eigen::Matrix3Xf> encoded);

}  // namespace sheen
