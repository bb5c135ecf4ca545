// SPDX-License-Identifier: Apache-2.0
#include "common/base/crc32c.h"

#include <array>
#include <bit>
#include <cstring>

namespace sheen {
namespace {

constexpr std::uint32_t kReflectedPolynomial = 0x82F63B78;

/// tables[k][b]: what byte b does to the register once k more bytes have gone through it.
constexpr auto make_tables() {
  std::array<std::array<std::uint32_t, 256>, 8> tables{};
  for (std::uint32_t b = 0; b < 256; ++b) {
    std::uint32_t value = b;
    for (int bit = 0; bit < 8; ++bit) value = value & 1 ? (value >> 1) ^ kReflectedPolynomial : value >> 1;
    tables[0][b] = value;
  }
  for (std::size_t k = 1; k < tables.size(); ++k)
    for (std::uint32_t b = 0; b < 256; ++b) tables[k][b] = (tables[k - 1][b] >> 8) ^ tables[0][tables[k - 1][b] & 0xFF];
  return tables;
}
constexpr auto kTables = make_tables();
static_assert(std::endian::native == std::endian::little);

std::uint64_t load64(const std::uint8_t* p) {
  std::uint64_t value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

#if defined(__x86_64__)
__attribute__((target("sse4.2"))) std::uint32_t by_instruction(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  std::uint64_t state = ~crc;
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) state = __builtin_ia32_crc32di(state, load64(bytes.data() + i));
  auto tail = static_cast<std::uint32_t>(state);
  for (; i < bytes.size(); ++i) tail = __builtin_ia32_crc32qi(tail, bytes[i]);
  return ~tail;
}
#endif

}  // namespace

std::uint32_t crc32c_portable(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  std::uint32_t state = ~crc;
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {
    const std::uint64_t word = load64(bytes.data() + i) ^ state;
    state = 0;
    for (int k = 0; k < 8; ++k) state ^= kTables[7 - k][(word >> (8 * k)) & 0xFF];
  }
  for (; i < bytes.size(); ++i) state = (state >> 8) ^ kTables[0][(state ^ bytes[i]) & 0xFF];
  return ~state;
}

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
#if defined(__x86_64__)
  static const bool has_instruction = __builtin_cpu_supports("sse4.2");
  if (has_instruction) return by_instruction(bytes, crc);
#endif
  return crc32c_portable(bytes, crc);
}

}  // namespace sheen
