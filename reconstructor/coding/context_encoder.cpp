// SPDX-License-Identifier: Apache-2.0
#include <draco/compression/entropy/ans.h>

#include "reconstructor/coding/context_coder.h"

namespace sheen {

bool ContextEncoder::bit(std::span<const int> contexts, int mixer, bool value) {
  bits_.emplace_back(value, model_.zeros_of_256(contexts, mixer));
  model_.learn(value);
  return value;
}

/// A stack: what is written last is read first.
std::string ContextEncoder::finish() {
  constexpr std::size_t kEnd = 4;
  std::string bytes(bits_.size() + kEnd, '\0');  // at most a byte for a bit
  draco::AnsCoder stack;
  draco::ans_write_init(&stack, reinterpret_cast<std::uint8_t*>(bytes.data()));
  for (auto bit = bits_.rbegin(); bit != bits_.rend(); ++bit) draco::rabs_write(&stack, bit->first, bit->second);
  bytes.resize(static_cast<std::size_t>(draco::ans_write_end(&stack)));
  return bytes;
}

}  // namespace sheen
