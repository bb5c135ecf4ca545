// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "reconstructor/coding/context_coder.h"

namespace sheen {

/// Small numbers that differ little from the one before.
template <typename Number>
std::string encode_differences(const std::vector<Number>& numbers) {
  BitModel bits(kSignedContexts);
  ContextEncoder coder(bits);
  std::int32_t last = 0;
  for (const Number number : numbers) {
    code_signed(coder, 0, number - last);
    last = number;
  }
  return coder.finish();
}

/// Throws std::runtime_error where one is less than `least` or more than `most`, or the bytes are no such stream.
template <typename Number>
std::vector<Number> decode_differences(std::string_view bytes, std::size_t count, Number least, Number most) {
  BitModel bits(kSignedContexts);
  ContextDecoder coder(bits, bytes);
  std::vector<Number> numbers(count);
  std::int32_t last = 0;
  for (Number& number : numbers) {
    last += code_signed(coder, 0, 0);
    if (last < least || last > most) throw std::runtime_error("holds a number out of its range");
    number = static_cast<Number>(last);
  }
  return numbers;
}

}  // namespace sheen
