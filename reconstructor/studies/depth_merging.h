// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/image/image.h"
#include "common/simulation/light_rig.h"

namespace sheen {

/// The paper's ways of making one depth map of those in several lights, for comparison: an intrinsic lumigraph adds up
/// the costs of its planes over all lights instead (`SweepCosts`).

/// 001 eq. 1: the mean of depth maps, weighted by their confidences. All are of one size and one channel, at least one
/// of each.
ImageF merge_depths(std::span<const ImageF> depths, std::span<const ImageF> confidences);

/// 001 eq. 2 to 4: the smaller eigenvalue of the structure tensor over 5 x 5 pixels of a grey image, a confidence.
ImageF texture_confidence(const ImageF& grey);

/// 001 figure 3: depth of a rig's central view, found in each light alone and in all of them together. z in camera
/// coordinates, metres.
struct DepthsByLight {
  ImageF truth;                   ///< 0 where there is nothing
  std::vector<ImageF> on_planes;  ///< per light: the best plane of a sweep
  std::vector<ImageF> refined;    ///< per light: found between planes as well
  ImageF by_variance;             ///< those on planes merged by eq. 1
  ImageF by_texture;              ///< those on planes merged by eq. 2 to 4
  ImageF by_all;                  ///< as a lumigraph does: costs of all lights added, then found between planes

  /// Mean absolute error of a depth map over the pixels that show a surface, metres.
  double error(const ImageF& depth) const;
  double least_error(const std::vector<ImageF>& depths) const;
};
DepthsByLight depths_by_light(const LightRig& rig);

}  // namespace sheen
