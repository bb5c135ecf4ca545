// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "reconstructor/capture/capture_set.h"
#include "reconstructor/refinement/refinement_images.h"

namespace sheen {

/// The captures with a pose.
struct PosedImages {
  RefinementImages images;
  std::vector<std::size_t> training, held_out;  ///< numbers of `images`
  std::vector<std::size_t> captures;            ///< of each of `images`: its number among the captures
};
/// Each is read once for it, and again when it is asked for.
PosedImages posed_images(const CaptureSet& captures, int hold_out_every);

/// The same captures, in the poses that `posed`, made of them, has now.
CaptureSet with_poses_of(const PosedImages& posed, CaptureSet captures);

/// The captures that a model may be built from: neither held out nor without a pose.
RefinementImages training_images(const CaptureSet& captures, int hold_out_every);

}  // namespace sheen
