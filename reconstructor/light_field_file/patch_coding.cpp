// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/patch_coding.h"

#include "reconstructor/light_field_file/patch_coder.h"

namespace sheen {

using namespace patch_coder;

LayerModels::LayerModels()
    : means(kContexts.all.end(), kMixers.all.end()), terms(kContexts.all.end(), kMixers.all.end()) {}

void decode_layer(const PatchLayout& layout, std::string_view bytes, std::vector<QuantisedPatch>& patches, int layer,
                  LayerModels& models) {
  ContextDecoder coder(models.of(layer), bytes);
  code_layer(coder, layout, patches, layer);
}

}  // namespace sheen
