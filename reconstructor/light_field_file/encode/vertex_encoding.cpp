// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/vertex_encoding.h"

#include "reconstructor/light_field_file/vertex_coder.h"

namespace sheen {

using namespace vertex_coder;

std::string encode_vertices(CompactModel& model) {
  BitModel bits(kVertexContexts, kVertexMixers);
  ContextEncoder coder(bits);
  VertexCoder(coder, model).code();
  return coder.finish();
}

}  // namespace sheen
