// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/patch_coding.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <stdexcept>

#include "reconstructor/coding/context_coder.h"

namespace sheen {
namespace {

using Values = std::vector<std::int32_t>;

constexpr std::size_t kSmooth = 10;  ///< frequencies of a tile in the first layer of the means

// What a value is likely to be depends on how large those are that it is like: its neighbours in frequency, the same
// frequency in the triangles before, in the other colours and in the term before. That expectation, in half octaves, is
// the context.
constexpr int kExpectations = 18;
constexpr int kColours = 3, kFrequencies = 3, kLengths = 13;

constexpr int kLengthHigh = 0;  ///< bits of a band's length, after those of the same band of the triangle before
constexpr int kLengthLow = kLengthHigh + kColours * kLengths * kLengths;
constexpr int kZero = kLengthLow + kColours * kLengths * 3;
constexpr int kSize = kZero + kColours * kFrequencies * kExpectations;
constexpr int kLevel = kSize + kColours * kExpectations * kNumberContexts;  ///< of means, beyond the triangle before
constexpr int kHasTerm = kLevel + kColours * kSignedContexts;
constexpr int kScale = kHasTerm + 2;
constexpr int kCoefficient = kScale + kSignedContexts;
constexpr int kSign = kCoefficient + kExpectations * kNumberContexts;
constexpr int kContexts = kSign + 1;

constexpr std::int32_t kUnit = 64;  ///< expectations are counted in 64ths

/// A damaged file adds up to anything.
std::int32_t within_range(long value) {
  constexpr long kMost = 1 << 24;
  return static_cast<std::int32_t>(std::clamp(value, -kMost, kMost));
}

/// Half octaves of an expectation: 0 below 1/16, then up.
int bucket(std::int32_t expectation) {
  if (expectation < 4) return 0;
  const int octave = std::bit_width(static_cast<std::uint32_t>(expectation)) - 1;  // >= 2
  const int half = (expectation >> (octave - 1)) & 1;
  return std::min(1 + 2 * (octave - 2) + half, kExpectations - 1);
}

int frequency_bucket(std::size_t frequency) {
  return frequency < 6 ? 0 : (frequency < 36 ? 1 : 2);
}

std::int32_t magnitude(const Values& values, std::size_t i) {
  return i < values.size() ? std::min(std::abs(values[i]), 4000) : 0;
}

/// A weighted mean of magnitudes.
class Expectation {
 public:
  void add(std::int32_t weight, std::int32_t magnitude_in_units) {
    sum_ += weight * magnitude_in_units;
    weight_ += weight;
  }
  int context() const { return bucket(weight_ > 0 ? sum_ / weight_ : 0); }

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
      code_map(t, patches[t].mean, nullptr, true, from, to);
    }
  }

  /// Term k of all patches that have it.
  void code_term(std::vector<QuantisedPatch>& patches, std::size_t k) {
    bool last = true;
    for (std::size_t t = 0; t < patches.size(); ++t) {
      QuantisedPatch& patch = patches[t];
      if (layout_.images[t] == 0 || patch.terms.size() < k) continue;
      last = coder_.bit(kHasTerm + last, patch.terms.size() > k);
      if (!last) continue;
      if (Coder::kReads) patch.terms.emplace_back();
      scale_ = within_range(scale_ + code_signed(coder_, kScale, patch.terms[k].scale - scale_));
      patch.terms[k].scale = scale_;
      code_coefficients(t, patch.terms[k].coefficients);
      code_map(t, patch.terms[k].map, k == 0 ? &patch.mean : &patch.terms[k - 1].map, false, 0, kAll);
    }
  }

 private:
  static constexpr std::size_t kAll = 1u << 20;

  void code_map(std::size_t patch, QuantisedMap& map, const QuantisedMap* before, bool mean, std::size_t from,
                std::size_t to) {
    const std::vector<int>& tiles = layout_.tile_sizes[patch];
    if (map.bands.empty()) map.bands.resize(3 * tiles.size());
    for (std::size_t band = 0; band < map.bands.size(); ++band) {
      const std::size_t colour = band % 3, size = static_cast<std::size_t>(tiles[band / 3]);
      Likes likes;
      for (std::size_t c = 0; c < colour; ++c) likes.colours[c] = &map.bands[band - colour + c].values;
      if (before) likes.before = &before->bands[band].values;
      std::vector<std::int32_t>& history = history_[colour][size];
      history.resize(size);
      if (mean && from == 0 && band < 3) code_level(patch, map.bands[band].values, colour);
      code_band(map.bands[band].values, likes, history, colour,
                mean && band < 3 ? std::max<std::size_t>(from, 1) : from, std::min(to, size));
    }
  }

  /// The level of a whole patch, beyond what that of the patch before lets expect: it grows by the root of the samples.
  void code_level(std::size_t patch, Values& values, std::size_t colour) {
    const std::vector<int>& tiles = layout_.tile_sizes[patch];
    const double root = std::sqrt(static_cast<double>(std::accumulate(tiles.begin(), tiles.end(), 0)));
    const std::int32_t expected = within_range(std::lround(root * level_[colour]));
    const std::int32_t level = expected + code_signed(coder_, kLevel + static_cast<int>(colour) * kSignedContexts,
                                                      (values.empty() ? 0 : values[0]) - expected);
    if (Coder::kReads) values.assign(1, level);
    level_[colour] = level / root;
  }

  /// What a band is like.
  struct Likes {
    const Values* colours[2] = {};   ///< luma, and the first colour difference, of the same triangle
    const Values* before = nullptr;  ///< the same band of the term before
  };

  /// `to`: of what follows there, a reader knows nothing yet.
  int context_at(const Values& values, const Likes& likes, const std::vector<std::int32_t>& history, std::size_t f,
                 std::size_t first, std::size_t to) const {
    const auto around = [f, to](const Values& like) {
      return kUnit *
             (2 * magnitude(like, f) + (f > 0 ? magnitude(like, f - 1) : 0) +
              (f + 1 < to ? magnitude(like, f + 1) : 0)) /
             4;
    };
    Expectation expected;
    constexpr std::int32_t kNear[] = {6, 4, 3, 2};
    for (std::size_t d = 1; d <= 4 && f >= first + d; ++d) expected.add(kNear[d - 1], kUnit * magnitude(values, f - d));
    expected.add(8, history[f]);
    for (const Values* colour : likes.colours)
      if (colour) expected.add(2, around(*colour));
    if (likes.before) expected.add(1, around(*likes.before));
    return expected.context();
  }

  void code_band(Values& values, const Likes& likes, std::vector<std::int32_t>& history, std::size_t colour,
                 std::size_t first, std::size_t to) {
    if (first >= to) return;
    const int c = static_cast<int>(colour);
    std::size_t length = std::min(values.size(), to);
    if (!Coder::kReads)
      while (length > first && values[length - 1] == 0) --length;
    length = code_length(length > first ? length - first : 0, c, length_before_[colour]);
    if (length > to - first) throw std::runtime_error("a band is longer than its tile");
    const std::size_t end = first + length;
    if (Coder::kReads && length > 0) values.resize(end);
    for (std::size_t f = first; f < end; ++f) {
      const int context = context_at(values, likes, history, f, first, to);
      const std::int32_t value = values[f];
      const bool must = f + 1 == end;
      if (!must &&
          !coder_.bit(kZero + (c * kFrequencies + frequency_bucket(f)) * kExpectations + context, value != 0)) {
        values[f] = 0;
        continue;
      }
      const auto size =
          static_cast<std::int32_t>(1 + code_number(coder_, kSize + (c * kExpectations + context) * kNumberContexts,
                                                    static_cast<std::uint32_t>(std::max(std::abs(value) - 1, 0))));
      values[f] = coder_.bit(kSign, value < 0) ? -size : size;
    }
    for (std::size_t f = first; f < to; ++f) history[f] += (kUnit * magnitude(values, f) - history[f]) / 4;
  }

  /// Its number of bits, then the bits.
  std::size_t code_length(std::size_t length, int colour, int& before) {
    const int wanted = static_cast<int>(std::bit_width(length));
    int bits = 0;
    while (bits < kLengths - 1 &&
           coder_.bit(kLengthHigh + (colour * kLengths + before) * kLengths + bits, wanted > bits))
      ++bits;
    before = bits;
    if (bits < 2) return static_cast<std::size_t>(bits);
    std::size_t read = 1;
    for (int i = bits - 2; i >= 0; --i) {
      const int depth = bits - 2 - i, low = kLengthLow + (colour * kLengths + bits) * 3;
      const int context = depth == 0 ? low : (depth == 1 ? low + 1 + static_cast<int>(read & 1) : kSign);
      read = 2 * read + coder_.bit(context, (length >> i) & 1);
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
      const int context = kCoefficient + expected.context() * kNumberContexts;
      const auto size =
          static_cast<std::int32_t>(code_number(coder_, context, static_cast<std::uint32_t>(std::abs(values[j]))));
      values[j] = size != 0 && coder_.bit(kSign, values[j] < 0) ? -size : size;
    }
  }

  Coder& coder_;
  const PatchLayout& layout_;
  double level_[3] = {};  ///< of the patch before, per root of a sample
  std::int32_t scale_ = 0;
  int length_before_[3] = {};
  std::map<std::size_t, std::vector<std::int32_t>>
      history_[3];  ///< by colour and size of the tile: mean magnitudes of late
};

template <typename Coder>
void code_layer(Coder& coder, const PatchLayout& layout, std::vector<QuantisedPatch>& patches, int layer) {
  LayerCoder<Coder> layers(coder, layout);
  if (layer == 0)
    layers.code_means(patches, 0, kSmooth);
  else if (layer == 1)
    layers.code_means(patches, kSmooth, 1u << 20);
  else
    layers.code_term(patches, static_cast<std::size_t>(layer - kMeanLayers));
}

}  // namespace

std::string encode_layer(const PatchLayout& layout, std::vector<QuantisedPatch>& patches, int layer) {
  ContextEncoder coder(kContexts);
  code_layer(coder, layout, patches, layer);
  return coder.finish();
}

void decode_layer(const PatchLayout& layout, std::string_view bytes, std::vector<QuantisedPatch>& patches, int layer) {
  ContextDecoder coder(kContexts, bytes);
  code_layer(coder, layout, patches, layer);
}

int layer_count(const std::vector<QuantisedPatch>& patches) {
  std::size_t terms = 0;
  for (const QuantisedPatch& patch : patches) terms = std::max(terms, patch.terms.size());
  return kMeanLayers + static_cast<int>(terms);
}

}  // namespace sheen
