// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "common/parallel/for_each.h"
#include "reconstructor/light_field_file/encode/canonical_mesh.h"
#include "reconstructor/light_field_file/encode/patch_quantising.h"

namespace sheen {

/// A surface light field as one file (docs/model_format.md). `step`: of `quantise`. `model`: what it knows of its
/// vertices becomes what a reader finds in the file.
std::string encode_light_field(CompactModel& model, const CanonicalMesh& mesh, float step, const Rounding& rounding,
                               const ForEach& for_each);

}  // namespace sheen
