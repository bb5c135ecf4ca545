// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/gl/basis_store.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <limits>

namespace sheen {
namespace {

constexpr std::size_t kFirstTexels = std::size_t(1) << 16;  // what OpenGL 3.3 promises at least

/// Texels (sample, term), the terms of a sample side by side.
void pack(const SurfacePatch& patch, int rank, std::vector<std::uint16_t>& texels) {
  const auto bits = [](float value) { return Eigen::numext::bit_cast<std::uint16_t>(Eigen::half(value)); };
  const std::size_t samples = patch.shown.size();
  texels.resize(samples * rank * 4);
  for (int r = 0; r < rank; ++r) {
    const Eigen::VectorXf values = patch.colours_of_term(r);
    const float* value = values.data();
    std::uint16_t* texel = texels.data() + 4 * r;
    for (std::size_t s = 0; s < samples; ++s, texel += 4 * rank, value += 3) {
      for (int c = 0; c < 3; ++c) texel[c] = bits(value[c]);
      texel[3] = bits(static_cast<float>(patch.state(static_cast<int>(s))));
    }
  }
}

}  // namespace

BasisStore::BasisStore(std::size_t max_buffer_texels)
    : max_buffer_texels_(std::min<std::size_t>(BufferTexture::max_texels(), std::numeric_limits<std::int32_t>::max())) {
  if (max_buffer_texels > 0) max_buffer_texels_ = std::min(max_buffer_texels_, max_buffer_texels);
}

bool BasisStore::grow(std::size_t texels) {
  if (exhausted_) return false;
  if (buffers_.empty() || buffers_.back().texture.texels() >= max_buffer_texels_) {
    if (buffers_.size() == kMaxBuffers) return false;
    buffers_.push_back({BufferTexture(GL_RGBA16F, kTexelBytes), {}});
  }
  Buffer& last = buffers_.back();
  const std::size_t now = last.texture.texels();
  const std::size_t wanted = std::min(max_buffer_texels_, std::max({now + texels, now + now / 2, kFirstTexels}));
  if (!last.texture.grow(wanted)) {
    exhausted_ = true;
    if (now == 0) buffers_.pop_back();
    return false;
  }
  last.ranges.extend(wanted - now);
  return true;
}

void BasisStore::reserve(std::size_t texels) {
  std::size_t room = texels_reserved() - texels_used();
  while (room < texels && grow(texels - room)) room = texels_reserved() - texels_used();
}

BasisSlot BasisStore::place(std::size_t texels) {
  do {
    for (std::size_t b = 0; b < buffers_.size(); ++b)
      if (const auto first = buffers_[b].ranges.allocate(texels))
        return {.first = static_cast<std::uint32_t>(*first),
                .buffer = static_cast<std::uint8_t>(b),
                .texels = static_cast<std::uint32_t>(texels)};
  } while (texels <= max_buffer_texels_ && grow(texels));
  return {};
}

BasisSlot BasisStore::store(const SurfacePatch& patch) {
  const std::size_t samples = patch.shown.size();
  if (samples == 0) return {};
  for (int rank = patch.rank(); rank > 0; rank /= 2) {
    BasisSlot slot = place(samples * rank);
    if (slot.texels == 0) continue;
    slot.rank = static_cast<std::uint16_t>(rank);
    pack(patch, rank, staging_);
    buffers_[slot.buffer].texture.write(slot.first, slot.texels, staging_.data());
    return slot;
  }
  return {};
}

void BasisStore::release(const BasisSlot& slot) {
  if (slot.texels > 0) buffers_[slot.buffer].ranges.release(slot.first, slot.texels);
}

std::size_t BasisStore::texels_used() const {
  std::size_t sum = 0;
  for (const Buffer& b : buffers_) sum += b.ranges.used();
  return sum;
}

std::size_t BasisStore::texels_reserved() const {
  std::size_t sum = 0;
  for (const Buffer& b : buffers_) sum += b.ranges.capacity();
  return sum;
}

void BasisStore::bind(int first_unit) const {
  if (buffers_.empty()) return;
  for (int b = 0; b < kMaxBuffers; ++b)
    buffers_[b < static_cast<int>(buffers_.size()) ? b : 0].texture.bind(first_unit + b);
}

}  // namespace sheen
