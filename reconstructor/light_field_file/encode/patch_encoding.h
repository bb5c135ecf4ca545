// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/light_field_file/patch_coding.h"

namespace sheen {

/// Leaves `patches` as they are.
std::string encode_layer(const PatchLayout& layout, std::vector<QuantisedPatch>& patches, int layer,
                         LayerModels& models);

/// Layers that these patches fill.
int layer_count(const std::vector<QuantisedPatch>& patches);

}  // namespace sheen
