// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/coding/context_coder.h"

#include <draco/compression/bit_coders/adaptive_rans_bit_decoder.h>
#include <draco/compression/bit_coders/adaptive_rans_bit_encoder.h>

#include <stdexcept>
#include <vector>

namespace sheen {

struct ContextEncoder::Streams {
  std::vector<draco::AdaptiveRAnsBitEncoder> encoders;
  std::vector<bool> used;
};

ContextEncoder::ContextEncoder(int contexts) : streams_(std::make_unique<Streams>()) {
  streams_->encoders.resize(static_cast<std::size_t>(contexts));
  streams_->used.resize(static_cast<std::size_t>(contexts));
  for (auto& encoder : streams_->encoders) encoder.StartEncoding();
}

ContextEncoder::~ContextEncoder() = default;

bool ContextEncoder::bit(int context, bool value) {
  streams_->encoders[static_cast<std::size_t>(context)].EncodeBit(value);
  streams_->used[static_cast<std::size_t>(context)] = true;
  return value;
}

/// A bit per context that was used, then the streams of those.
std::string ContextEncoder::finish() {
  draco::EncoderBuffer buffer;
  std::string used((streams_->used.size() + 7) / 8, '\0');
  for (std::size_t i = 0; i < streams_->used.size(); ++i)
    if (streams_->used[i]) {
      used[i / 8] = static_cast<char>(used[i / 8] | (1 << (i % 8)));
      streams_->encoders[i].EndEncoding(&buffer);
    }
  return used + std::string(buffer.data(), buffer.size());
}

struct ContextDecoder::Streams {
  std::vector<draco::AdaptiveRAnsBitDecoder> decoders;
  std::vector<bool> used;
};

ContextDecoder::ContextDecoder(int contexts, std::string_view bytes) : streams_(std::make_unique<Streams>()) {
  const auto count = static_cast<std::size_t>(contexts), marks = (count + 7) / 8;
  streams_->decoders.resize(count);
  streams_->used.resize(count);
  if (bytes.size() < marks) throw std::runtime_error("is cut short");
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data() + marks, bytes.size() - marks);
  buffer.set_bitstream_version(DRACO_BITSTREAM_VERSION(2, 2));
  for (std::size_t i = 0; i < count; ++i)
    if ((static_cast<unsigned char>(bytes[i / 8]) >> (i % 8)) & 1) {
      if (!streams_->decoders[i].StartDecoding(&buffer)) throw std::runtime_error("is damaged");
      streams_->used[i] = true;
    }
}

ContextDecoder::~ContextDecoder() = default;

bool ContextDecoder::bit(int context, bool) {
  const auto i = static_cast<std::size_t>(context);
  return streams_->used[i] && streams_->decoders[i].DecodeNextBit();
}

}  // namespace sheen
