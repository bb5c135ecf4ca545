// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/patch_encoding.h"

#include "reconstructor/light_field_file/patch_coder.h"

namespace sheen {

using namespace patch_coder;

std::string encode_layer(const PatchLayout& layout, std::vector<QuantisedPatch>& patches, int layer,
                         LayerModels& models) {
  ContextEncoder coder(models.of(layer));
  code_layer(coder, layout, patches, layer);
  return coder.finish();
}

int layer_count(const std::vector<QuantisedPatch>& patches) {
  std::size_t terms = 0;
  for (const QuantisedPatch& patch : patches) terms = std::max(terms, patch.terms.size());
  return kMeanLayers + static_cast<int>(terms);
}

}  // namespace sheen
