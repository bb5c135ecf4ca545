// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "reconstructor/coding/context_coder.h"
#include "reconstructor/light_field_file/grid_geometry.h"
#include "reconstructor/light_field_file/patch_coding.h"

/// How layers of patches are coded: one description that writing and reading share.
namespace sheen::patch_coder {

using Values = std::vector<std::int32_t>;

// What a value is likely to be depends on how large those are that it is like: its neighbours in frequency, the same
// frequency in the triangles before, in the other colours and in the term before. A context is their mean, in half
// octaves; others are the single ones.
constexpr int kExpectations = 18;
constexpr int kSmall = 3;  ///< sizes 0, 1, more
constexpr int kColours = 3, kFrequencies = 3, kOctaves = 10, kLengths = 13;
constexpr int kLowStarts = 8;  ///< what is known of a length's second to fourth bit

/// Ranges of contexts, or of mixers, one behind the other.
class Ranges {
 public:
  constexpr int next(int size) { return std::exchange(end_, end_ + size); }
  constexpr int end() const { return end_; }

 private:
  int end_ = 0;
};

struct Contexts {
  Ranges all;
  // A band's length: its number of bits, then the bits.
  int bits_by_past = all.next(kColours * kLengths * kLengths * kLengths);   ///< after the two triangles before
  int bits_by_likes = all.next(kColours * kLengths * kLengths * kLengths);  ///< after the term before and other colours
  int bits_by_last = all.next(kColours * kLengths * kLengths);
  int low_by_whole = all.next(kColours * kLengths * kLowStarts * kLengths);
  int low_by_past = all.next(kColours * kLengths * kLowStarts * kLengths);
  int low_rest = all.next(1);
  // Values.
  int zero = all.next(kColours * kFrequencies * kExpectations);
  int zero_by_near = all.next(kColours * kSmall * kSmall * kSmall * kSmall * kSmall);
  int zero_by_mean = all.next(kColours * kOctaves * kExpectations);
  int size = all.next(kColours * kExpectations * kNumberContexts);
  int size_by_past = all.next(kColours * kExpectations * kSmall * kNumberContexts);
  int level = all.next(kColours * kSignedContexts);  ///< of means, beyond the triangle before
  // Terms.
  int has_term = all.next(2);
  int scale = all.next(kSignedContexts);
  int coefficient = all.next(kExpectations * kNumberContexts);
  int sign = all.next(1);
};
constexpr Contexts kContexts;

struct Mixers {
  Ranges all;
  int bits = all.next(kColours * kLengths);
  int low = all.next(kLengths);
  int zero = all.next(kColours * kOctaves);
  int size = all.next(kColours * kNumberContexts);
};
constexpr Mixers kMixers;

constexpr std::int32_t kUnit = 64;  ///< expectations are counted in 64ths

/// A damaged file adds up to anything.
inline std::int32_t within_range(std::int64_t value) {
  constexpr std::int64_t kMost = 1 << 24;
  return static_cast<std::int32_t>(std::clamp(value, -kMost, kMost));
}

/// Half octaves of an expectation: 0 below 1/16, then up.
inline int bucket(std::int32_t expectation) {
  if (expectation < 4) return 0;
  const int octave = std::bit_width(static_cast<std::uint32_t>(expectation)) - 1;  // >= 2
  const int half = (expectation >> (octave - 1)) & 1;
  return std::min(1 + 2 * (octave - 2) + half, kExpectations - 1);
}

inline int frequency_bucket(std::size_t frequency) {
  return frequency < 6 ? 0 : (frequency < 36 ? 1 : 2);
}

/// Octaves of a number: 0, 1, 2 to 3, 4 to 7 and so on.
template <int kEnd>
int octave(std::size_t number) {
  return std::min(static_cast<int>(std::bit_width(number)), kEnd - 1);
}

inline std::int32_t magnitude(std::span<const std::int32_t> values, std::size_t i) {
  return i < values.size() ? std::min(std::abs(values[i]), 4000) : 0;
}

/// A weighted mean of magnitudes.
class Expectation {
 public:
  void add(std::int32_t weight, std::int32_t magnitude_in_units) {
    sum_ += weight * magnitude_in_units;
    weight_ += weight;
  }
  int in_half_octaves() const { return bucket(weight_ > 0 ? sum_ / weight_ : 0); }

 private:
  std::int32_t sum_ = 0, weight_ = 0;
};

template <typename Coder>
class LayerCoder {
 public:
  LayerCoder(Coder& coder, const PatchLayout& layout) : coder_(coder), layout_(layout) {}

  /// The frequencies from..to of all means.
  void code_means(std::vector<QuantisedPatch>& patches, std::size_t from, std::size_t to) {
    for (std::size_t t = 0; t < patches.size(); ++t) {
      if (layout_.images[t] == 0) continue;
      patches[t].known = true;
      code_map(t, patches[t].mean, nullptr, nullptr, from, to);
    }
  }

  /// Term k of all patches that have it.
  void code_term(std::vector<QuantisedPatch>& patches, std::size_t k) {
    bool last = true;
    for (std::size_t t = 0; t < patches.size(); ++t) {
      QuantisedPatch& patch = patches[t];
      if (layout_.images[t] == 0 || patch.terms.size() < k) continue;
      last = coder_.bit(kContexts.has_term + last, patch.terms.size() > k);
      if (!last) continue;
      if (Coder::kReads) patch.terms.emplace_back();
      scale_ = within_range(scale_ + code_signed(coder_, kContexts.scale, patch.terms[k].scale - scale_));
      patch.terms[k].scale = scale_;
      code_coefficients(t, patch.terms[k].coefficients);
      code_map(t, patch.terms[k].map, &patch.mean, k == 0 ? &patch.mean : &patch.terms[k - 1].map, 0, kAll);
    }
  }

 private:
  static constexpr std::size_t kAll = 1u << 20;

  /// mean, before: of the patch, where a term is coded.
  void code_map(std::size_t patch, QuantisedMap& map, const QuantisedMap* mean, const QuantisedMap* before,
                std::size_t from, std::size_t to) {
    const std::vector<int>& tiles = layout_.tile_sizes[patch];
    take_out(map, 3 * tiles.size());
    for (std::size_t band = 0; band < bands_.size(); ++band) {
      const std::size_t colour = band % 3, size = static_cast<std::size_t>(tiles[band / 3]);
      Likes likes;
      for (std::size_t c = 0; c < colour; ++c) likes.colours[c] = bands_[band - colour + c];
      if (before) likes.before = before->band(band);
      if (mean) likes.mean = mean->band(band);
      History& history = history_[colour];
      std::vector<std::int32_t>& magnitudes = history.magnitudes[size];
      magnitudes.resize(size);
      const bool level = !mean && band < 3;
      if (level && from == 0) code_level(patch, bands_[band], colour);
      code_band(bands_[band], likes, history, magnitudes, static_cast<int>(colour),
                level ? std::max<std::size_t>(from, 1) : from, std::min(to, size));
    }
    if (Coder::kReads) map.assign(bands_);
  }

  /// The bands of a map as far as they are known, to be worked on.
  void take_out(const QuantisedMap& map, std::size_t bands) {
    bands_.resize(bands);
    for (std::size_t i = 0; i < bands; ++i) {
      const QuantisedMap::Band band = map.empty() ? QuantisedMap::Band() : map.band(i);
      bands_[i].assign(band.begin(), band.end());
    }
  }

  /// The level of a whole patch, beyond what that of the patch before lets expect: it grows by the root of the samples.
  void code_level(std::size_t patch, Values& values, std::size_t colour) {
    constexpr int kRatioBits = 10;
    const std::vector<int>& tiles = layout_.tile_sizes[patch];
    const std::int64_t samples = std::accumulate(tiles.begin(), tiles.end(), std::int64_t{0});
    Level& last = level_[colour];
    const std::int64_t ratio = integer_root((samples << (2 * kRatioBits)) / last.samples);
    const std::int32_t expected = within_range((last.value * ratio + (1 << (kRatioBits - 1))) >> kRatioBits);
    const std::int32_t level =
        expected + code_signed(coder_, kContexts.level + static_cast<int>(colour) * kSignedContexts,
                               (values.empty() ? 0 : values[0]) - expected);
    if (Coder::kReads) values.assign(1, level);
    last = {within_range(level), samples};
  }

  /// What a band is like.
  struct Likes {
    using Band = std::optional<QuantisedMap::Band>;
    Band colours[2];  ///< luma, and the first colour difference, of the same triangle
    Band before;      ///< the same band of the term before
    Band mean;        ///< the same band of the mean
  };

  /// What the bands of a colour were like of late.
  struct History {
    int bits[2] = {};                                             ///< of lengths, the last one first
    std::map<std::size_t, std::vector<std::int32_t>> magnitudes;  ///< by size of the tile: of each frequency
  };

  /// `to`: of what follows there, a reader knows nothing yet.
  int expected_at(const Values& values, const Likes& likes, std::int32_t past, std::size_t f, std::size_t first,
                  std::size_t to) const {
    const auto around = [f, to](QuantisedMap::Band like) {
      return kUnit *
             (2 * magnitude(like, f) + (f > 0 ? magnitude(like, f - 1) : 0) +
              (f + 1 < to ? magnitude(like, f + 1) : 0)) /
             4;
    };
    Expectation expected;
    constexpr std::int32_t kNear[] = {6, 4, 3, 2};
    for (std::size_t d = 1; d <= 4 && f >= first + d; ++d) expected.add(kNear[d - 1], kUnit * magnitude(values, f - d));
    expected.add(8, past);
    for (const typename Likes::Band& colour : likes.colours)
      if (colour) expected.add(2, around(*colour));
    if (likes.before) expected.add(1, around(*likes.before));
    return expected.in_half_octaves();
  }

  void code_band(Values& values, const Likes& likes, History& history, std::vector<std::int32_t>& past, int colour,
                 std::size_t first, std::size_t to) {
    if (first >= to) return;
    const std::size_t length =
        code_length(length_of(QuantisedMap::Band(values), first, to), likes, history, colour, first, to);
    if (length > to - first) throw std::runtime_error("a band is longer than its tile");
    const std::size_t end = first + length;
    if (Coder::kReads && length > 0) values.resize(end);
    for (std::size_t f = first; f < end; ++f) {
      const int expected = expected_at(values, likes, past[f], f, first, to);
      const bool zero = f + 1 < end && !code_nonzero(values, likes, expected, colour, f, first);
      values[f] = zero ? 0 : code_value(values[f], likes, expected, past[f], colour, f);
    }
    for (std::size_t f = first; f < to; ++f) past[f] += (kUnit * magnitude(values, f) - past[f]) / 4;
  }

  static int small(const typename Likes::Band& values, std::size_t i) {
    return values ? std::min(magnitude(*values, i), kSmall - 1) : 0;
  }

  bool code_nonzero(const Values& values, const Likes& likes, int expected, int colour, std::size_t f,
                    std::size_t first) {
    int near = 0;
    for (std::size_t d = 1; d <= 2; ++d)
      near = kSmall * near + (f >= first + d ? small(QuantisedMap::Band(values), f - d) : 0);
    for (const typename Likes::Band& like : {likes.colours[0], likes.colours[1], likes.before})
      near = kSmall * near + small(like, f);
    const int octaves = octave<kOctaves>(f), mean = likes.mean ? bucket(kUnit * magnitude(*likes.mean, f)) : 0;
    const int contexts[] = {
        kContexts.zero + (colour * kFrequencies + frequency_bucket(f)) * kExpectations + expected,
        kContexts.zero_by_near + colour * kSmall * kSmall * kSmall * kSmall * kSmall + near,
        kContexts.zero_by_mean + (colour * kOctaves + octaves) * kExpectations + mean,
    };
    return coder_.bit(contexts, kMixers.zero + colour * kOctaves + octaves, values[f] != 0);
  }

  /// That is not zero.
  std::int32_t code_value(std::int32_t value, const Likes& likes, int expected, std::int32_t past, int colour,
                          std::size_t f) {
    const std::array contexts = {
        kContexts.size + (colour * kExpectations + expected) * kNumberContexts,
        kContexts.size_by_past +
            ((colour * kExpectations + bucket(past)) * kSmall + small(likes.before, f)) * kNumberContexts,
    };
    const auto size =
        1 + static_cast<std::int32_t>(code_number(coder_, contexts, kMixers.size + colour * kNumberContexts,
                                                  static_cast<std::uint32_t>(std::max(std::abs(value) - 1, 0))));
    return coder_.bit(kContexts.sign, value < 0) ? -size : size;
  }

  /// Frequencies from `first` on, as far as one before `to` is not zero.
  static std::size_t length_of(const typename Likes::Band& band, std::size_t first, std::size_t to) {
    std::size_t end = band ? std::min(band->size(), to) : 0;
    while (end > first && (*band)[end - 1] == 0) --end;
    return end > first ? end - first : 0;
  }

  /// Its number of bits, then the bits.
  std::size_t code_length(std::size_t length, const Likes& likes, History& history, int colour, std::size_t first,
                          std::size_t to) {
    const auto bits_of = [first, to](const typename Likes::Band& band) {
      return octave<kLengths>(length_of(band, first, to));
    };
    const int term_before = bits_of(likes.before),
              colours = std::max(bits_of(likes.colours[0]), bits_of(likes.colours[1])),
              whole = octave<kLengths>(to - first), wanted = octave<kLengths>(length);
    const int last = std::exchange(history.bits[0], 0), older = std::exchange(history.bits[1], last);
    int bits = 0;
    for (; bits < kLengths - 1; ++bits) {
      const int contexts[] = {
          kContexts.bits_by_past + ((colour * kLengths + last) * kLengths + older) * kLengths + bits,
          kContexts.bits_by_likes + ((colour * kLengths + term_before) * kLengths + colours) * kLengths + bits,
          kContexts.bits_by_last + (colour * kLengths + last) * kLengths + bits,
      };
      if (!coder_.bit(contexts, kMixers.bits + colour * kLengths + bits, wanted > bits)) break;
    }
    history.bits[0] = bits;
    if (bits < 2) return static_cast<std::size_t>(bits);
    std::size_t read = 1;  // the first bit is a one
    for (int i = bits - 2; i >= 0; --i) {
      const bool one = (length >> i) & 1;
      if (read < kLowStarts) {
        const int start = (colour * kLengths + bits) * kLowStarts + static_cast<int>(read);
        const int contexts[] = {kContexts.low_by_whole + start * kLengths + whole,
                                kContexts.low_by_past + start * kLengths + last};
        read = 2 * read + coder_.bit(contexts, kMixers.low + bits, one);
      } else {
        read = 2 * read + coder_.bit(kContexts.low_rest, one);
      }
    }
    return read;
  }

  /// From coarse to fine: a difference is about as large as that of the group that it is part of.
  void code_coefficients(std::size_t patch, Values& values) {
    const std::vector<std::uint16_t>& parent = layout_.haar_parent[patch];
    if (Coder::kReads) values.assign(layout_.images[patch], 0);
    for (std::size_t j = 0; j < values.size(); ++j) {
      Expectation expected;
      if (j > 1) expected.add(2, kUnit * magnitude(values, static_cast<std::size_t>(parent[j])));
      for (std::size_t d = 1; d <= 3 && j > d; ++d) expected.add(1, kUnit * magnitude(values, j - d));
      const int context = kContexts.coefficient + expected.in_half_octaves() * kNumberContexts;
      const auto size =
          static_cast<std::int32_t>(code_number(coder_, context, static_cast<std::uint32_t>(std::abs(values[j]))));
      values[j] = size != 0 && coder_.bit(kContexts.sign, values[j] < 0) ? -size : size;
    }
  }

  Coder& coder_;
  const PatchLayout& layout_;
  /// Of a patch of so many samples.
  struct Level {
    std::int64_t value = 0, samples = 1;
  };
  Level level_[kColours];  ///< of the patch before
  std::int32_t scale_ = 0;
  History history_[kColours];
  std::vector<Values> bands_;  ///< of the map that is coded
};

template <typename Coder>
void code_layer(Coder& coder, const PatchLayout& layout, std::vector<QuantisedPatch>& patches, int layer) {
  LayerCoder<Coder> layers(coder, layout);
  if (layer == 0)
    layers.code_means(patches, 0, kSmoothFrequencies);
  else if (layer == 1)
    layers.code_means(patches, kSmoothFrequencies, 1u << 20);
  else
    layers.code_term(patches, static_cast<std::size_t>(layer - kMeanLayers));
}

}  // namespace sheen::patch_coder
