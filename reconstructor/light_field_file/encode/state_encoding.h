// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/light_field_file/state_coding.h"

namespace sheen {

/// For each sample of the model, whether it was measured. Most triangles are of one state; in others a sample follows
/// those beside it, and those of the triangle across the nearest edge.
std::string encode_states(const CompactModel& model);

}  // namespace sheen
