// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

namespace sheen {

using Bytes = std::span<const std::uint8_t>;

struct BrokenFrame : std::runtime_error {
  BrokenFrame() : std::runtime_error("broken zstd frame") {}
};

inline void require(bool holds) {
  if (!holds) throw BrokenFrame();
}

/// So many bytes from the front, which are taken away.
inline Bytes take(Bytes& bytes, std::size_t count) {
  require(count <= bytes.size());
  const Bytes taken = bytes.first(count);
  bytes = bytes.subspan(count);
  return taken;
}

/// A little-endian number of so many bytes from the front, which are taken away.
inline std::uint64_t take_number(Bytes& bytes, std::size_t count) {
  const Bytes taken = take(bytes, count);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value |= std::uint64_t{taken[i]} << (8 * i);
  return value;
}

/// Of a number above 0: the place of its highest bit.
inline int highest_bit(std::uint64_t value) {
  int bit = -1;
  for (; value > 0; value >>= 1) ++bit;
  return bit;
}

/// Bits that are read from the end of the bytes to their beginning. Behind the beginning they are 0.
class BackwardBits {
 public:
  explicit BackwardBits(Bytes bytes) : bytes_(bytes) {
    require(!bytes.empty() && bytes.back() != 0);  // its highest bit marks the end
    left_ = 8 * (static_cast<std::int64_t>(bytes.size()) - 1) + highest_bit(bytes.back());
  }

  std::uint64_t read(int count) {
    left_ -= count;
    return bits_at(left_, count);
  }
  std::uint64_t peek(int count) const { return bits_at(left_ - count, count); }
  void skip(int count) { left_ -= count; }
  std::int64_t left() const { return left_; }  ///< negative: more were read than there are

 private:
  std::uint64_t bits_at(std::int64_t first, int count) const {
    std::uint64_t value = 0;
    for (std::int64_t bit = first + count; bit > first;) {  // from the highest byte down
      const std::int64_t byte = (bit - 1) >> 3, low = std::max(first, 8 * byte);
      const int bits = static_cast<int>(bit - low);
      const unsigned here = byte >= 0 && byte < static_cast<std::int64_t>(bytes_.size()) ? bytes_[byte] : 0;
      value = value << bits | ((here >> (low - 8 * byte)) & ((1u << bits) - 1));
      bit = low;
    }
    return value;
  }

  Bytes bytes_;
  std::int64_t left_;
};

}  // namespace sheen
