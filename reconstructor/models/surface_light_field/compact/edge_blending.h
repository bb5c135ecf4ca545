// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/models/surface_light_field/compact/compact_model.h"

namespace sheen {

/// Two triangles with a common edge have the same colours along it, but quantised apart they differ by a step or so: a
/// seam. Each takes the mean of both there: of the means everywhere, of the terms inside a patch, where both have the
/// same ones.
void blend_edges(CompactModel& model);

}  // namespace sheen
