// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "reconstructor/radiance/radiance_image.h"
#include "reconstructor/surface/map_layout.h"
#include "reconstructor/surface/sample_visibility.h"

namespace sheen {

/// The colours that an image gives to the surface samples it shows, interpolated as linear radiance, divided by `gain`
/// and encoded (`srgb_encode`): a column for each sample that faces the camera (`SurfaceView::first`), or more. Columns
/// of samples that are not visible are left as they were.
void resample(const RadianceImage& image, const SurfaceView& view, const MapLayout& maps, float gain,
              Eigen::Matrix3Xf& encoded, Sampling sampling = Sampling::kCubic);

/// The same of some triangles only.
void resample(const RadianceImage& image, const SurfaceView& view, const MapLayout& maps,
              std::span<const std::uint32_t> triangles, float gain, Eigen::Matrix3Xf& encoded,
              Sampling sampling = Sampling::kCubic);

}  // namespace sheen
