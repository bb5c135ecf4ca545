// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/state_coding.h"

#include "reconstructor/light_field_file/state_coder.h"

namespace sheen {

using namespace state_coder;

void decode_states(std::string_view bytes, CompactModel& model) {
  std::vector<SampleState> states(model.maps->total_samples());
  BitModel bits(kStateContexts, kStateMixers);
  ContextDecoder coder(bits, bytes);
  StateCoder(coder, model, states).code();
  for (std::size_t t = 0; t < model.maps->triangles(); ++t) {
    const auto first = states.begin() + static_cast<std::ptrdiff_t>(model.maps->first_sample(t));
    std::copy(first, first + lattice_samples(model.maps->resolution(t)),
              model.patches[model.shapes.patch_of[t]].state.begin() + model.shapes.first_sample[t]);
  }
}

}  // namespace sheen
