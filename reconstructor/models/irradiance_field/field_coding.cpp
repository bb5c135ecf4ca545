// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/field_coding.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "reconstructor/coding/context_coder.h"

namespace sheen {
namespace {

// Smaller values than this part of a step less than one are rounded to zero: it costs less than it keeps.
constexpr float kRounding = 0.4f;
// The basis takes this part of the error that the maps have.
constexpr double kBasisPart = 0.05;
constexpr int kMostBits = 20;
constexpr std::int32_t kMostCoefficient = 1 << 22;

// Contexts: sizes of values by the size of those that they are like and by their frequency; then the reach of tiles;
// then the basis.
constexpr int kSizes = 16, kBands = 5, kReaches = 12;
constexpr int kReachContexts = kSizes * kBands * kSignedContexts;
constexpr int kBasisContexts = kReachContexts + kReaches * kNumberContexts;
constexpr int kHeadContexts = kBasisContexts + kSignedContexts;
constexpr int kContexts = kHeadContexts + kNumberContexts;

int band_of(int sum) {
  return sum == 0 ? 0 : sum == 1 ? 1 : sum < 4 ? 2 : sum < 8 ? 3 : 4;
}

/// By the sum of the weighted sizes of the values that it is like, in half octaves.
int size_of(int likes) {
  if (likes == 0) return 0;
  int size = 1;
  for (int limit = 2; size < kSizes - 1 && likes > limit; limit += limit / 2 + 1) ++size;
  return size;
}

/// The maps of a component, term by term and tile by tile, to be written or read.
class Maps {
 public:
  Maps(const TileGrid& grid, std::vector<std::int32_t>& values) : grid_(grid), values_(values) {
    for (int k = 0; k < kTilePixels; ++k) {
      const auto [u, v] = tile_frequency(k);
      at_[static_cast<std::size_t>(v * kTileSide + u)] = k;
    }
    reach_.resize(2 * grid.tiles());
  }

  template <typename Coder>
  void code(Coder& coder, std::size_t terms) {
    for (std::size_t term = 0; term < terms; ++term) {
      for (std::size_t tile = 0; tile < grid_.tiles(); ++tile) code_tile(coder, term, tile);
      std::swap_ranges(reach_.begin(), reach_.begin() + static_cast<std::ptrdiff_t>(grid_.tiles()),
                       reach_.begin() + static_cast<std::ptrdiff_t>(grid_.tiles()));
    }
  }

 private:
  std::int32_t* tile_at(std::size_t term, std::size_t tile) {
    return values_.data() + (term * grid_.tiles() + tile) * kTilePixels;
  }

  /// One more than the highest sum of frequencies that is not zero.
  static std::uint32_t reach_of(const std::int32_t* values) {
    for (int k = kTilePixels - 1; k >= 0; --k)
      if (values[k] != 0) {
        const auto [u, v] = tile_frequency(k);
        return static_cast<std::uint32_t>(u + v + 1);
      }
    return 0;
  }

  template <typename Coder>
  void code_tile(Coder& coder, std::size_t term, std::size_t tile) {
    const auto across = static_cast<std::size_t>(grid_.across);
    std::int32_t* values = tile_at(term, tile);
    const std::int32_t* left = tile % across > 0 ? values - kTilePixels : nullptr;
    const std::int32_t* above = tile >= across ? values - across * kTilePixels : nullptr;
    const std::int32_t* before = term > 0 ? tile_at(term - 1, tile) : nullptr;

    // This term's reaches stand in the first half, those of the term before in the second.
    const std::uint32_t likes = (left ? reach_[tile - 1] : 0) + (above ? reach_[tile - across] : 0) +
                                2 * (before ? reach_[grid_.tiles() + tile] : 0);
    const int context = std::min(static_cast<int>((likes + 3) / 4), kReaches - 1);
    const std::uint32_t reach =
        code_number(coder, kReachContexts + context * kNumberContexts, Coder::kReads ? 0 : reach_of(values));
    if (reach > 2 * kTileSide - 1) throw std::runtime_error("holds a frequency that no tile has");
    reach_[tile] = reach;
    for (int k = 0; k < kTilePixels; ++k) {
      const auto [u, v] = tile_frequency(k);
      if (u + v >= static_cast<int>(reach)) break;
      const auto size = [](const std::int32_t* list, int i) { return list ? std::min(std::abs(list[i]), 1 << 16) : 0; };
      const auto own = [&](int x, int y) {
        return x < 0 || y < 0 ? 0 : size(values, at_[static_cast<std::size_t>(y * kTileSide + x)]);
      };
      const int sum = 4 * (size(left, k) + size(above, k) + own(u - 1, v) + own(u, v - 1)) + 3 * size(before, k) +
                      2 * (own(u - 1, v - 1) + own(u - 2, v) + own(u, v - 2));
      const int sort = band_of(u + v) * kSizes + size_of(sum);
      values[k] = code_signed(coder, sort * kSignedContexts, values[k]);
    }
  }

  TileGrid grid_;
  std::vector<std::int32_t>& values_;
  std::array<int, kTilePixels> at_{};  ///< where a frequency stands in a tile
  std::vector<std::uint32_t> reach_;
};

template <typename Coder>
void code_component(Coder& coder, const QuantisedField& field, QuantisedField::Component& component) {
  const auto lights = static_cast<std::size_t>(field.lights);
  const TileGrid grid = tile_grid(field.size);
  const std::size_t terms = component.terms();
  component.basis.resize(terms * lights);
  component.coefs.resize(terms * grid.tiles() * kTilePixels);
  for (std::uint8_t& bits : component.bits) {
    const std::uint32_t value = code_number(coder, kHeadContexts, bits);
    if (value > kMostBits) throw std::runtime_error("holds a basis finer than any");
    bits = static_cast<std::uint8_t>(value);
  }
  for (std::int32_t& value : component.basis) value = code_signed(coder, kBasisContexts, value);
  Maps(grid, component.coefs).code(coder, terms);
}

}  // namespace

QuantisedField quantise(const FieldTerms& field, int lights, float step) {
  QuantisedField quantised{.size = field.size, .lights = lights, .step = step};
  for (std::size_t c = 0; c < field.components.size(); ++c) {
    const FieldTerms::Component& from = field.components[c];
    QuantisedField::Component& to = quantised.components[c];
    const auto rows = static_cast<std::size_t>(from.coefs.rows());
    const auto rounded = [step](float value) {
      const float steps = value / step;
      const auto size = static_cast<std::int32_t>(std::min(std::abs(steps) + kRounding, float{kMostCoefficient}));
      return steps < 0 ? -size : size;
    };
    Eigen::Index terms = from.coefs.cols();
    while (terms > 0 && rounded(from.coefs.col(terms - 1).cwiseAbs().maxCoeff()) == 0) --terms;
    to.coefs.reserve(static_cast<std::size_t>(terms) * rows);
    for (Eigen::Index t = 0; t < terms; ++t) {
      for (const float value : from.coefs.col(t)) to.coefs.push_back(rounded(value));
      // An error d of a basis column is one of d * rms in the images; n of them add up in each.
      const double rms = from.coefs.col(t).norm() / std::sqrt(static_cast<double>(rows)),
                   unit = std::sqrt(kBasisPart / lights) * step / std::max(rms, 1e-9);
      const int bits = std::clamp(static_cast<int>(std::ceil(-std::log2(unit))), 0, kMostBits);
      to.bits.push_back(static_cast<std::uint8_t>(bits));
      for (const float value : from.basis.col(t))
        to.basis.push_back(static_cast<std::int32_t>(std::lround(std::ldexp(value, bits))));
    }
  }
  return quantised;
}

FieldTerms dequantise(const QuantisedField& field) {
  FieldTerms terms{.size = field.size};
  for (std::size_t c = 0; c < field.components.size(); ++c) {
    const QuantisedField::Component& from = field.components[c];
    FieldTerms::Component& to = terms.components[c];
    const auto count = static_cast<Eigen::Index>(from.terms());
    const auto rows = static_cast<Eigen::Index>(tile_grid(field.size).tiles()) * kTilePixels;
    to.basis = Eigen::Map<const Eigen::MatrixXi>(from.basis.data(), field.lights, count).cast<float>();
    for (Eigen::Index t = 0; t < count; ++t)
      to.basis.col(t) *= std::ldexp(1.0f, -from.bits[static_cast<std::size_t>(t)]);
    to.coefs = field.step * Eigen::Map<const Eigen::MatrixXi>(from.coefs.data(), rows, count).cast<float>();
  }
  return terms;
}

std::string encode_component(const QuantisedField& field, std::size_t component) {
  QuantisedField::Component copy = field.components[component];
  BitModel bits(kContexts);
  ContextEncoder encoder(bits);
  code_component(encoder, field, copy);
  return encoder.finish();
}

void decode_component(std::string_view bytes, QuantisedField& field, std::size_t component) {
  BitModel bits(kContexts);
  ContextDecoder decoder(bits, bytes);
  code_component(decoder, field, field.components[component]);
}

}  // namespace sheen
