// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/capture/capture_set.h"
#include "reconstructor/refinement/mesh_refinement.h"

namespace sheen {

/// The captures that a model may be built from: neither held out nor without a pose. Each is read once for it, and
/// again when it is asked for.
RefinementImages training_images(const CaptureSet& captures, int hold_out_every);

}  // namespace sheen
