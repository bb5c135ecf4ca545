// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/page/wasm/zstd_tables.h"

namespace sheen {
namespace {

constexpr int kLargestWeightLog = 6, kLongestCode = 11;
constexpr std::size_t kMostWeights = 255;

/// Bits that are read from the front.
class ForwardBits {
 public:
  explicit ForwardBits(Bytes bytes) : bytes_(bytes) {}
  unsigned read(int count) {
    unsigned value = 0;
    for (int i = 0; i < count; ++i, ++place_) {
      require(place_ / 8 < bytes_.size());
      value |= ((bytes_[place_ / 8] >> place_ % 8) & 1u) << i;
    }
    return value;
  }
  void back(int count) { place_ -= static_cast<std::size_t>(count); }
  std::size_t bytes_used() const { return (place_ + 7) / 8; }

 private:
  Bytes bytes_;
  std::size_t place_ = 0;
};

/// By two states that take turns (4.2.1.2).
std::vector<std::uint8_t> coded_weights(Bytes bytes) {
  const EntropyTable table = EntropyTable::read(bytes, kLargestWeightLog, kMostWeights);
  BackwardBits bits(bytes);
  EntropyState one(table, bits), other(table, bits);
  std::vector<std::uint8_t> weights;
  for (EntropyState *now = &one, *then = &other; weights.size() < kMostWeights; std::swap(now, then)) {
    weights.push_back(now->symbol());
    now->next(bits);
    if (bits.left() >= 0) continue;
    weights.push_back(then->symbol());
    return weights;
  }
  throw BrokenFrame();
}

std::vector<std::uint8_t> plain_weights(Bytes& bytes, std::size_t count) {
  const Bytes pairs = take(bytes, (count + 1) / 2);
  std::vector<std::uint8_t> weights;
  for (std::size_t i = 0; i < count; ++i) weights.push_back(i % 2 == 0 ? pairs[i / 2] >> 4 : pairs[i / 2] & 15);
  return weights;
}

}  // namespace

EntropyTable EntropyTable::of(std::span<const std::int16_t> counts, int log) {
  EntropyTable table{log, std::vector<Entry>(std::size_t{1} << log)};
  const std::size_t size = table.entries.size(), mask = size - 1, step = (size >> 1) + (size >> 3) + 3;
  std::vector<unsigned> next(counts.size());
  std::size_t high = size;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    if (counts[s] >= 0) continue;
    table.entries[--high].symbol = static_cast<std::uint8_t>(s);
    next[s] = 1;
  }
  std::size_t at = 0;
  for (std::size_t s = 0; s < counts.size(); ++s)
    for (int i = 0; i < counts[s]; ++i) {
      next[s] = static_cast<unsigned>(counts[s]);
      table.entries[at].symbol = static_cast<std::uint8_t>(s);
      do at = (at + step) & mask;
      while (at >= high);
    }
  for (Entry& entry : table.entries) {
    const unsigned state = next[entry.symbol]++;
    entry.bits = static_cast<std::uint8_t>(log - highest_bit(state));
    entry.base = static_cast<std::uint16_t>((state << entry.bits) - size);
  }
  return table;
}

EntropyTable EntropyTable::read(Bytes& bytes, int largest_log, std::size_t most_symbols) {
  ForwardBits bits(bytes);
  const int log = static_cast<int>(bits.read(4)) + 5;
  require(log <= largest_log);
  std::vector<std::int16_t> counts;
  int left = 1 << log;
  while (left > 0) {
    require(counts.size() < most_symbols);
    // A number below left + 2, in as few bits as tell it from the others.
    const int length = highest_bit(static_cast<std::uint64_t>(left) + 1) + 1;
    const int low = (1 << (length - 1)) - 1, short_ones = (1 << length) - 1 - (left + 1);
    int value = static_cast<int>(bits.read(length));
    if ((value & low) < short_ones) {
      bits.back(1);
      value &= low;
    } else if (value > low) {
      value -= short_ones;
    }
    counts.push_back(static_cast<std::int16_t>(value - 1));
    left -= value == 0 ? 1 : value - 1;
    for (unsigned zeros = value == 1 ? 3 : 0; zeros == 3;) {
      zeros = bits.read(2);
      counts.insert(counts.end(), zeros, 0);
    }
  }
  require(left == 0 && counts.size() <= most_symbols);
  take(bytes, bits.bytes_used());
  return of(counts, log);
}

HuffmanTable HuffmanTable::read(Bytes& bytes) {
  const auto head = static_cast<std::size_t>(take_number(bytes, 1));
  std::vector<std::uint8_t> weights = head < 128 ? coded_weights(take(bytes, head)) : plain_weights(bytes, head - 127);
  std::size_t places = 0;
  for (const std::uint8_t weight : weights) {
    require(weight <= kLongestCode);
    places += weight > 0 ? std::size_t{1} << (weight - 1) : 0;
  }
  require(places > 0);
  HuffmanTable table{highest_bit(places) + 1, {}};
  require(table.log <= kLongestCode);
  const std::size_t left = (std::size_t{1} << table.log) - places;  // of the last symbol, which is not told
  require((left & (left - 1)) == 0 && weights.size() < 256);
  weights.push_back(static_cast<std::uint8_t>(highest_bit(left) + 1));
  for (int weight = 1; weight <= table.log; ++weight)
    for (std::size_t s = 0; s < weights.size(); ++s)
      if (weights[s] == weight)
        table.entries.insert(table.entries.end(), std::size_t{1} << (weight - 1),
                             {static_cast<std::uint8_t>(s), static_cast<std::uint8_t>(table.log + 1 - weight)});
  return table;
}

void HuffmanTable::decode(Bytes bytes, std::span<std::uint8_t> out) const {
  require(!entries.empty());
  BackwardBits bits(bytes);
  for (std::uint8_t& symbol : out) {
    const Entry& entry = entries[bits.peek(log)];
    symbol = entry.symbol;
    bits.skip(entry.bits);
  }
  require(bits.left() == 0);
}

}  // namespace sheen
