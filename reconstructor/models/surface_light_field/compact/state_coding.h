// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "reconstructor/models/surface_light_field/compact/compact_model.h"

namespace sheen {

/// For each sample of the model, whether it was measured. Most triangles are of one state; in others a sample follows
/// those beside it, and those of the triangle across the nearest edge.
std::string encode_states(const CompactModel& model);

/// Into the model, whose patches have their sizes. Throws std::runtime_error where the bytes are no such stream.
void decode_states(std::string_view bytes, CompactModel& model);

}  // namespace sheen
