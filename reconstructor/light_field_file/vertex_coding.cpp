// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/vertex_coding.h"

#include "reconstructor/light_field_file/vertex_coder.h"

namespace sheen {

using namespace vertex_coder;

void decode_vertices(std::string_view bytes, CompactModel& model) {
  BitModel bits(kVertexContexts, kVertexMixers);
  ContextDecoder coder(bits, bytes);
  model.vertices.assign(model.mesh->vertices.size(), {});
  VertexCoder(coder, model).code();
}

}  // namespace sheen
