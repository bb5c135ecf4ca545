// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/state_encoding.h"

#include "reconstructor/light_field_file/state_coder.h"

namespace sheen {

using namespace state_coder;

std::string encode_states(const CompactModel& model) {
  std::vector<SampleState> states(model.maps->total_samples());
  for (std::size_t t = 0; t < model.maps->triangles(); ++t) {
    const auto first = model.patches[model.shapes.patch_of[t]].state.begin() + model.shapes.first_sample[t];
    std::copy(first, first + lattice_samples(model.maps->resolution(t)),
              states.begin() + static_cast<std::ptrdiff_t>(model.maps->first_sample(t)));
  }
  BitModel bits(kStateContexts, kStateMixers);
  ContextEncoder coder(bits);
  StateCoder(coder, model, states).code();
  return coder.finish();
}

}  // namespace sheen
