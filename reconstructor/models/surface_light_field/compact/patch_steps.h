// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "reconstructor/models/surface_light_field/compact/compact_model.h"

namespace sheen {

/// How coarse the step of each patch is beside the model's own, in quarter octaves. What the images show large, and
/// from many sides, has a finer one: an error there costs more pixels.
std::vector<std::int8_t> choose_patch_steps(const CompactModel& model);

/// `quarter_octaves`: of `choose_patch_steps`.
float step_of_patch(float step, std::int8_t quarter_octaves);

std::string encode_patch_steps(const std::vector<std::int8_t>& steps);
/// Throws std::runtime_error.
std::vector<std::int8_t> decode_patch_steps(std::string_view bytes, std::size_t patches);

}  // namespace sheen
