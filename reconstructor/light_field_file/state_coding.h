// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "reconstructor/light_field_file/compact_model.h"

namespace sheen {

/// Into the model, whose patches have their sizes. Throws std::runtime_error where the bytes are no such stream.
void decode_states(std::string_view bytes, CompactModel& model);

}  // namespace sheen
