// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/coding/context_coder.h"

#include <draco/compression/entropy/ans.h>

#include <limits>
#include <stdexcept>

namespace sheen {
namespace {

constexpr unsigned kLeastState = 4096;  // of the stack, before each bit: Draco's, which its header keeps to itself

}  // namespace

struct ContextDecoder::Stream {
  draco::AnsDecoder stack;
};

ContextDecoder::ContextDecoder(BitModel& model, std::string_view bytes)
    : model_(model), stream_(std::make_unique<Stream>()) {
  if (bytes.empty() || bytes.size() > std::numeric_limits<int>::max()) throw std::runtime_error("is cut short");
  if (draco::ans_read_init(&stream_->stack, reinterpret_cast<const std::uint8_t*>(bytes.data()),
                           static_cast<int>(bytes.size())) != 0)
    throw std::runtime_error("is damaged");
}

ContextDecoder::~ContextDecoder() = default;

bool ContextDecoder::bit(std::span<const int> contexts, int mixer, bool) {
  if (stream_->stack.state < kLeastState && stream_->stack.buf_offset == 0) throw std::runtime_error("is cut short");
  const bool value = draco::rabs_read(&stream_->stack, model_.zeros_of_256(contexts, mixer)) != 0;
  model_.learn(value);
  return value;
}

}  // namespace sheen
