// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "reconstructor/light_field_file/patch_spectrum.h"

namespace sheen {

/// What is left out, which a reader need not know.
struct Rounding {
  float bit_price = 0.12f;   ///< squared steps that a bit is worth
  float least_term = 0.12f;  ///< part of a step that a term must add to the picture
};

/// `step`: of the surface maps, in grey levels (of 255). All maps have the same, so that every byte goes where it adds
/// most to the picture (reverse water-filling); coefficients have a finer one, a fixed part of it. Terms that add too
/// little for the step, and those behind them, are dropped.
/// `resolutions`: of the patch's triangles, in their order.
QuantisedPatch quantise(const Patch& patch, const std::vector<int>& resolutions, const ViewHaar::Plan& plan, float step,
                        const Rounding& rounding);

}  // namespace sheen
