// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reconstructor/coding/bit_model.h"

namespace sheen {

/// Bits, each in contexts that learn how likely a one is there (binary arithmetic coding). Encoder and decoder have the
/// same functions, so that one description of what is coded, a template, serves both: `bit` takes the bit that is to be
/// written, or none that counts, and gives the bit that is there. Both keep `model`, which must outlive them; what it
/// learned may serve a next stream.
class ContextEncoder {
 public:
  static constexpr bool kReads = false;
  explicit ContextEncoder(BitModel& model) : model_(model) {}
  bool bit(int context, bool value) { return bit(std::span(&context, 1), 0, value); }
  /// In several contexts, mixed by one of the model's mixers.
  bool bit(std::span<const int> contexts, int mixer, bool value);
  std::string finish();

 private:
  BitModel& model_;
  std::vector<std::pair<bool, std::uint8_t>> bits_;  ///< each with what was expected of a zero: coded last bit first
};

class ContextDecoder {
 public:
  static constexpr bool kReads = true;
  /// Keeps `bytes`, which must outlive it. Throws std::runtime_error where they are no such stream.
  ContextDecoder(BitModel& model, std::string_view bytes);
  ~ContextDecoder();
  /// Throws std::runtime_error beyond the end.
  bool bit(int context, bool unused = false) { return bit(std::span(&context, 1), 0, unused); }
  bool bit(std::span<const int> contexts, int mixer, bool unused = false);

 private:
  struct Stream;
  BitModel& model_;
  std::unique_ptr<Stream> stream_;
};

/// Contexts that `code_number` takes from each first one on; and mixers, where it has several.
inline constexpr int kNumberContexts = 40;

/// A number >= 0, small ones in few bits: one by one up to 15, from there by its size. At most 2^23.
/// `contexts`: where those begin that it stands in; `mixer`: where theirs begin.
template <typename Coder, std::size_t kCount>
std::uint32_t code_number(Coder& coder, const std::array<int, kCount>& contexts, int mixer, std::uint32_t value) {
  constexpr std::uint32_t kOneByOne = 15;
  const auto bit = [&](int place, bool one) {
    std::array<int, kCount> at = contexts;
    for (int& context : at) context += place;
    return coder.bit(at, mixer + place, one);
  };
  std::uint32_t count = 0;
  while (count < kOneByOne && bit(static_cast<int>(count), value > count)) ++count;
  if (count < kOneByOne) return count;
  const std::uint32_t rest = value - kOneByOne + 1;  // >= 1
  int size = 0;
  while (size < 23 && bit(15 + size, (rest >> (size + 1)) != 0)) ++size;
  std::uint32_t read = 1;
  for (int i = size - 1; i >= 0; --i) read = 2 * read + bit(kNumberContexts - 1, (rest >> i) & 1);
  return read - 1 + kOneByOne;
}

template <typename Coder>
std::uint32_t code_number(Coder& coder, int context, std::uint32_t value) {
  return code_number(coder, std::array{context}, 0, value);
}

/// With a sign, in contexts of its own behind those of the number.
template <typename Coder, std::size_t kCount>
std::int32_t code_signed(Coder& coder, const std::array<int, kCount>& contexts, int mixer, std::int32_t value) {
  const auto size = static_cast<std::int32_t>(
      code_number(coder, contexts, mixer, static_cast<std::uint32_t>(value < 0 ? -value : value)));
  std::array<int, kCount> sign = contexts;
  for (int& context : sign) context += kNumberContexts;
  return size != 0 && coder.bit(sign, mixer + kNumberContexts, value < 0) ? -size : size;
}
inline constexpr int kSignedContexts = kNumberContexts + 1;

template <typename Coder>
std::int32_t code_signed(Coder& coder, int context, std::int32_t value) {
  return code_signed(coder, std::array{context}, 0, value);
}

}  // namespace sheen
