// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "reconstructor/page/wasm/zstd_bits.h"

namespace sheen {

/// A table of finite state entropy (RFC 8878, 4.1): a state is a symbol and the way to the next state.
struct EntropyTable {
  struct Entry {
    std::uint8_t symbol = 0, bits = 0;
    std::uint16_t base = 0;
  };
  int log = 0;
  std::vector<Entry> entries;

  /// `counts`: of each symbol among 2^log states; -1: less than one.
  static EntropyTable of(std::span<const std::int16_t> counts, int log);
  static EntropyTable of_symbol(std::uint8_t symbol) { return {0, {{symbol, 0, 0}}}; }
  /// Reads its description off the front of the bytes.
  static EntropyTable read(Bytes& bytes, int largest_log, std::size_t most_symbols);
};

class EntropyState {
 public:
  EntropyState(const EntropyTable& table, BackwardBits& bits) : table_(table), state_(bits.read(table.log)) {}
  std::uint8_t symbol() const { return entry().symbol; }
  void next(BackwardBits& bits) { state_ = entry().base + bits.read(entry().bits); }

 private:
  const EntropyTable::Entry& entry() const { return table_.entries[state_]; }
  const EntropyTable& table_;
  std::size_t state_;
};

/// Huffman codes of bytes, the longest first in a table of all that may follow.
struct HuffmanTable {
  struct Entry {
    std::uint8_t symbol = 0, bits = 0;
  };
  int log = 0;
  std::vector<Entry> entries;

  /// Reads its description off the front of the bytes.
  static HuffmanTable read(Bytes& bytes);
  /// Decodes as many bytes as `out` has from all of the bits.
  void decode(Bytes bits, std::span<std::uint8_t> out) const;
};

}  // namespace sheen
