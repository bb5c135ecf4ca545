// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "reconstructor/light_field_file/compact_model.h"

namespace sheen {

/// Into `model`, of which mesh, cameras, kernels and reflection must be there. Throws std::runtime_error.
void decode_vertices(std::string_view bytes, CompactModel& model);

}  // namespace sheen
