// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "reconstructor/models/surface_light_field/compact/compact_model.h"

namespace sheen {

/// How coarse the step of each patch is beside the model's own, in quarter octaves. What the images show large, and
/// from many sides, has a finer one: an error there costs more pixels.
std::vector<std::int8_t> choose_patch_steps(const CompactModel& model);

/// `quarter_octaves`: of `choose_patch_steps`.
float step_of_patch(float step, std::int8_t quarter_octaves);

/// No step is further from the model's: a damaged file asks for anything, and floats end somewhere.
inline constexpr std::int8_t kFurthestPatchStep = 32;

}  // namespace sheen
