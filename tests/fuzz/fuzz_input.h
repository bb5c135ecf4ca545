// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>

namespace sheen::fuzz {

/// Cuts pieces off the front of the fuzzer's input; zeros when it is used up.
struct Input {
  std::span<const std::uint8_t> rest;

  std::uint8_t byte() {
    if (rest.empty()) return 0;
    const std::uint8_t value = rest[0];
    rest = rest.subspan(1);
    return value;
  }
  std::size_t size16() {
    const std::size_t low = byte();
    return low | std::size_t(byte()) << 8;
  }
  /// Any value of the type, NaN and infinity among them; the most significant byte comes first.
  template <typename T>
  T bits() {
    std::uint8_t bytes[sizeof(T)];
    for (std::size_t i = sizeof(T); i-- > 0;) bytes[i] = byte();
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }
  std::span<const std::uint8_t> take(std::size_t size) {
    const auto piece = rest.first(std::min(size, rest.size()));
    rest = rest.subspan(piece.size());
    return piece;
  }
  std::string text() const { return {rest.begin(), rest.end()}; }
};

/// Overwrites, removes and inserts a byte of `bytes`, as the input says.
template <typename Bytes>
void damage_once(Bytes& bytes, Input& in) {
  const std::size_t at = in.size16() % (bytes.size() + 1);
  const std::uint8_t what = in.byte();
  const auto value = static_cast<typename Bytes::value_type>(in.byte());
  const auto position = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  if (at == bytes.size() || what % 4 == 0)
    bytes.insert(position, value);
  else if (what % 4 == 1)
    bytes.erase(position);
  else
    *position = value;
}

/// A property of the result that does not hold: what libFuzzer reports with the input that led to it.
[[noreturn]] inline void fail(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}
inline void demand(bool holds, const char* what) {
  if (!holds) fail(what);
}

}  // namespace sheen::fuzz
