// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace sheen {

/// Bits, each in a context that learns how likely a one is there (binary arithmetic coding). Encoder and decoder have
/// the same functions, so that one description of what is coded, a template, serves both: `bit` takes the bit that is
/// to be written, or none that counts, and gives the bit that is there.
class ContextEncoder {
 public:
  static constexpr bool kReads = false;
  explicit ContextEncoder(int contexts);
  ~ContextEncoder();
  bool bit(int context, bool value);
  std::string finish();

 private:
  struct Streams;
  std::unique_ptr<Streams> streams_;
};

class ContextDecoder {
 public:
  static constexpr bool kReads = true;
  /// Keeps `bytes`, which must outlive it. Throws std::runtime_error where they are no such stream. Bits beyond the end
  /// are anything.
  ContextDecoder(int contexts, std::string_view bytes);
  ~ContextDecoder();
  bool bit(int context, bool unused = false);

 private:
  struct Streams;
  std::unique_ptr<Streams> streams_;
};

/// Contexts that `code_number` takes from its first one on.
inline constexpr int kNumberContexts = 40;

/// A number >= 0, small ones in few bits: one by one up to 15, from there by its size. At most 2^23.
template <typename Coder>
std::uint32_t code_number(Coder& coder, int context, std::uint32_t value) {
  constexpr std::uint32_t kOneByOne = 15;
  std::uint32_t count = 0;
  while (count < kOneByOne && coder.bit(context + static_cast<int>(count), value > count)) ++count;
  if (count < kOneByOne) return count;
  const std::uint32_t rest = value - kOneByOne + 1;  // >= 1
  int size = 0;
  while (size < 23 && coder.bit(context + 15 + size, (rest >> (size + 1)) != 0)) ++size;
  std::uint32_t read = 1;
  for (int i = size - 1; i >= 0; --i) read = 2 * read + coder.bit(context + kNumberContexts - 1, (rest >> i) & 1);
  return read - 1 + kOneByOne;
}

/// With a sign, in a context of its own behind those of the number.
template <typename Coder>
std::int32_t code_signed(Coder& coder, int context, std::int32_t value) {
  const auto size =
      static_cast<std::int32_t>(code_number(coder, context, static_cast<std::uint32_t>(value < 0 ? -value : value)));
  return size != 0 && coder.bit(context + kNumberContexts, value < 0) ? -size : size;
}
inline constexpr int kSignedContexts = kNumberContexts + 1;

}  // namespace sheen
