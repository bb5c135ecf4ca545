// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "reconstructor/models/surface_light_field/compact/compact_model.h"

namespace sheen {

/// The vertices of a model: which were seen, in which images, and how patches are interpolated there. Reliabilities are
/// kept to a sixth of a stop, sills to a twelfth of an octave, directions of merged views to a thousandth. What a
/// reader will find is left in `model`.
std::string encode_vertices(CompactModel& model);
/// Into `model`, of which mesh, cameras, kernels and reflection must be there. Throws std::runtime_error.
void decode_vertices(std::string_view bytes, CompactModel& model);

}  // namespace sheen
