// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/light_field_file/vertex_coding.h"

namespace sheen {

/// The vertices of a model: which were seen, in which images, and how patches are interpolated there. Reliabilities are
/// kept to a sixth of a stop, sills to a twelfth of an octave, directions of merged views to a thousandth. What a
/// reader will find is left in `model`.
std::string encode_vertices(CompactModel& model);

}  // namespace sheen
