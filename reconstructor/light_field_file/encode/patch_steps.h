// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/parallel/for_each.h"
#include "reconstructor/light_field_file/compact_model.h"

namespace sheen {

/// How coarse the step of each patch is beside the model's own, in quarter octaves. What the images show large, and
/// from many sides, has a finer one: an error there costs more pixels.
std::vector<std::int8_t> choose_patch_steps(const CompactModel& model, const ForEach& for_each);

}  // namespace sheen
