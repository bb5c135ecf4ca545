// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/page/wasm/zstd_frame.h"

#include <algorithm>
#include <array>
#include <vector>

#include "reconstructor/page/wasm/zstd_tables.h"

namespace sheen {
namespace {

constexpr std::uint32_t kMagic = 0xFD2FB528;
constexpr std::size_t kLargestBlock = std::size_t{1} << 17;

// 3.1.1.3.2.1.1: numbers are told by a code and so many bits more; and how often codes are, where a block does not say.
constexpr int kLiteralCodes = 36, kMatchCodes = 53, kOffsetCodes = 32;
constexpr std::uint8_t kLiteralBits[kLiteralCodes] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,  0,  0,  0,  0,  1,  1,
                                                      1, 1, 2, 2, 3, 3, 4, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
constexpr std::uint8_t kMatchBits[kMatchCodes] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,  0,  0,  0,  0,  0,  0, 0,
                                                  0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,  0,  0,  0,  1,  1,  1, 1,
                                                  2, 2, 3, 3, 4, 4, 5, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
constexpr std::int16_t kLiteralCounts[kLiteralCodes] = {4, 3, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 1, 1,  1,  2,  2,
                                                        2, 2, 2, 2, 2, 2, 2, 3, 2, 1, 1, 1, 1, 1, -1, -1, -1, -1};
constexpr std::int16_t kMatchCounts[kMatchCodes] = {1, 4, 3, 2, 2, 2, 2, 2, 2, 1, 1,  1,  1,  1,  1,  1,  1, 1,
                                                    1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,  1,  1,  1,  1,  1,  1, 1,
                                                    1, 1, 1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1, -1, -1};
constexpr std::int16_t kOffsetCounts[29] = {1, 1, 1, 1, 1, 1, 2, 2, 2, 1,  1,  1,  1,  1, 1,
                                            1, 1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1};

/// The smallest number of each code, where the first one's is `first`.
template <std::size_t n>
std::array<std::uint32_t, n> bases(const std::uint8_t (&bits)[n], std::uint32_t first) {
  std::array<std::uint32_t, n> base{};
  for (std::size_t i = 0; i < n; ++i) {
    base[i] = first;
    first += std::uint32_t{1} << bits[i];
  }
  return base;
}

struct FrameHead {
  std::optional<std::uint64_t> size;
  bool checksum = false;
};

FrameHead take_head(Bytes& bytes) {
  require(take_number(bytes, 4) == kMagic);
  const auto flags = static_cast<unsigned>(take_number(bytes, 1));
  const bool one_segment = flags & 32;
  require((flags & 8) == 0 && (flags & 3) == 0);  // no dictionary
  if (!one_segment) take(bytes, 1);               // window
  FrameHead head{.checksum = (flags & 4) != 0};
  switch (flags >> 6) {
    case 0:
      if (one_segment) head.size = take_number(bytes, 1);
      break;
    case 1:
      head.size = take_number(bytes, 2) + 256;
      break;
    default:
      head.size = take_number(bytes, flags >> 6 == 2 ? 4 : 8);
  }
  return head;
}

/// What blocks leave to those behind them, and where they write.
class Unpacking {
 public:
  explicit Unpacking(std::span<std::uint8_t> out) : out_(out) {}

  void add_plain(Bytes bytes) {
    require(bytes.size() <= out_.size() - done_);
    std::copy(bytes.begin(), bytes.end(), out_.begin() + static_cast<std::ptrdiff_t>(done_));
    done_ += bytes.size();
  }
  void add_run(std::uint8_t byte, std::size_t length) {
    require(length <= out_.size() - done_);
    std::fill_n(out_.begin() + static_cast<std::ptrdiff_t>(done_), length, byte);
    done_ += length;
  }
  void add_block(Bytes block) {
    const std::vector<std::uint8_t> literals = take_literals(block);
    Bytes rest(literals);
    add_sequences(block, rest);
    add_plain(rest);
  }
  bool full() const { return done_ == out_.size(); }

 private:
  struct Codes {
    EntropyTable literals, offsets, matches;
  };

  std::vector<std::uint8_t> take_literals(Bytes& block) {
    require(!block.empty());
    const unsigned type = block[0] & 3, format = block[0] >> 2 & 3;
    if (type < 2) {
      const std::size_t head = format == 1 ? 2 : format == 3 ? 3 : 1;
      const auto size = static_cast<std::size_t>(take_number(block, head) >> (head == 1 ? 3 : 4));
      require(size <= kLargestBlock);
      if (type == 1) return std::vector<std::uint8_t>(size, static_cast<std::uint8_t>(take_number(block, 1)));
      const Bytes plain = take(block, size);
      return {plain.begin(), plain.end()};
    }
    const int bits = format < 2 ? 10 : format == 2 ? 14 : 18;
    const std::uint64_t head = take_number(block, static_cast<std::size_t>(4 + 2 * bits + 7) / 8) >> 4;
    const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
    const auto size = static_cast<std::size_t>(head & mask);
    require(size <= kLargestBlock);
    Bytes coded = take(block, static_cast<std::size_t>(head >> bits & mask));
    if (type == 2) huffman_ = HuffmanTable::read(coded);
    std::vector<std::uint8_t> literals(size);
    if (format == 0)
      huffman_.decode(coded, literals);
    else
      decode_four(coded, literals);
    return literals;
  }

  void decode_four(Bytes coded, std::span<std::uint8_t> literals) const {
    std::size_t sizes[3];
    for (std::size_t& size : sizes) size = static_cast<std::size_t>(take_number(coded, 2));
    const std::size_t quarter = (literals.size() + 3) / 4;
    require(3 * quarter <= literals.size());
    for (const std::size_t size : sizes) {
      huffman_.decode(take(coded, size), literals.first(quarter));
      literals = literals.subspan(quarter);
    }
    huffman_.decode(coded, literals);
  }

  static void take_table(Bytes& block, unsigned mode, std::span<const std::int16_t> usual, int usual_log,
                         int largest_log, std::size_t codes, EntropyTable& table) {
    switch (mode) {
      case 0:
        table = EntropyTable::of(usual, usual_log);
        break;
      case 1: {
        const auto symbol = static_cast<std::uint8_t>(take_number(block, 1));
        require(symbol < codes);
        table = EntropyTable::of_symbol(symbol);
        break;
      }
      case 2:
        table = EntropyTable::read(block, largest_log, codes);
        break;
      default:
        require(!table.entries.empty());  // that of the block before
    }
  }

  static std::size_t take_count(Bytes& block) {
    const auto first = static_cast<std::size_t>(take_number(block, 1));
    if (first < 128) return first;
    if (first < 255) return ((first - 128) << 8) + static_cast<std::size_t>(take_number(block, 1));
    return static_cast<std::size_t>(take_number(block, 2)) + 0x7F00;
  }

  void add_sequences(Bytes block, Bytes& literals) {
    static const auto kLiteralBases = bases(kLiteralBits, 0);
    static const auto kMatchBases = bases(kMatchBits, 3);
    const std::size_t count = take_count(block);
    if (count == 0) return;
    const auto modes = static_cast<unsigned>(take_number(block, 1));
    take_table(block, modes >> 6, kLiteralCounts, 6, 9, kLiteralCodes, codes_.literals);
    take_table(block, modes >> 4 & 3, kOffsetCounts, 5, 8, kOffsetCodes, codes_.offsets);
    take_table(block, modes >> 2 & 3, kMatchCounts, 6, 9, kMatchCodes, codes_.matches);
    BackwardBits bits(block);
    EntropyState literal(codes_.literals, bits), offset(codes_.offsets, bits), match(codes_.matches, bits);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t distance = (std::size_t{1} << offset.symbol()) + bits.read(offset.symbol());
      const std::size_t length = kMatchBases[match.symbol()] + bits.read(kMatchBits[match.symbol()]);
      const std::size_t plain = kLiteralBases[literal.symbol()] + bits.read(kLiteralBits[literal.symbol()]);
      require(bits.left() >= 0);
      add_plain(take(literals, plain));
      copy(distance_of(distance, plain == 0), length);
      if (i + 1 == count) break;
      literal.next(bits);
      match.next(bits);
      offset.next(bits);
    }
    require(bits.left() == 0);
  }

  /// The last three distances are told by numbers up to 3 (3.1.1.5).
  std::size_t distance_of(std::size_t told, bool no_literals) {
    std::size_t distance = told - 3, used = 3;
    if (told <= 3) {
      used = told - 1 + (no_literals ? 1 : 0);
      distance = used < 3 ? last_[used] : last_[0] - 1;
    }
    for (std::size_t i = std::min<std::size_t>(used, 2); i > 0; --i) last_[i] = last_[i - 1];
    return last_[0] = distance;
  }

  void copy(std::size_t distance, std::size_t length) {
    require(distance > 0 && distance <= done_ && length <= out_.size() - done_);
    for (std::size_t i = 0; i < length; ++i, ++done_) out_[done_] = out_[done_ - distance];  // may overlap
  }

  std::span<std::uint8_t> out_;
  std::size_t done_ = 0;
  HuffmanTable huffman_;
  Codes codes_;
  std::array<std::size_t, 3> last_{1, 4, 8};
};

void unpack(Bytes frame, std::span<std::uint8_t> out) {
  const FrameHead head = take_head(frame);
  Unpacking unpacking(out);
  for (bool last = false; !last;) {
    const auto block = static_cast<std::size_t>(take_number(frame, 3));
    const std::size_t size = block >> 3;
    last = block & 1;
    switch (block >> 1 & 3) {
      case 0:
        unpacking.add_plain(take(frame, size));
        break;
      case 1:
        unpacking.add_run(static_cast<std::uint8_t>(take_number(frame, 1)), size);
        break;
      case 2:
        unpacking.add_block(take(frame, size));
        break;
      default:
        throw BrokenFrame();
    }
  }
  take(frame, head.checksum ? 4 : 0);
  require(unpacking.full());
}

}  // namespace

std::optional<std::uint64_t> zstd_content_size(std::span<const std::uint8_t> frame) {
  try {
    return take_head(frame).size;
  } catch (const BrokenFrame&) {
    return std::nullopt;
  }
}

bool unpack_zstd(std::span<const std::uint8_t> frame, std::span<std::uint8_t> out) {
  try {
    unpack(frame, out);
    return true;
  } catch (const BrokenFrame&) {
    return false;
  }
}

}  // namespace sheen
