// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "common/image/image.h"

namespace sheen {

/// The paper's ways of making one depth map of those in several lights, for comparison: an intrinsic lumigraph adds up
/// the costs of its planes over all lights instead (`SweepCosts`).

/// 001 eq. 1: the mean of depth maps, weighted by their confidences. All are of one size and one channel, at least one
/// of each.
ImageF merge_depths(std::span<const ImageF> depths, std::span<const ImageF> confidences);

/// 001 eq. 2 to 4: the smaller eigenvalue of the structure tensor over 5 x 5 pixels of a grey image, a confidence.
ImageF texture_confidence(const ImageF& grey);

}  // namespace sheen
