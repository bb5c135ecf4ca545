// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <vector>

#include "reconstructor/coding/context_coder.h"
#include "reconstructor/irradiance_field_file/quantised_field.h"

// How the bits of an irradiance field's component stand in contexts: one description for what reads and what writes.
namespace sheen::field_coder {

inline constexpr int kMostBits = 20;  ///< of a basis

// Contexts: sizes of values by the size of those that they are like and by their frequency; then the reach of tiles;
// then the basis.
inline constexpr int kSizes = 16, kBands = 5, kReaches = 12;
inline constexpr int kReachContexts = kSizes * kBands * kSignedContexts;
inline constexpr int kBasisContexts = kReachContexts + kReaches * kNumberContexts;
inline constexpr int kHeadContexts = kBasisContexts + kSignedContexts;
inline constexpr int kContexts = kHeadContexts + kNumberContexts;

inline int band_of(int sum) {
  return sum == 0 ? 0 : sum == 1 ? 1 : sum < 4 ? 2 : sum < 8 ? 3 : 4;
}

/// By the sum of the weighted sizes of the values that it is like, in half octaves.
inline int size_of(int likes) {
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

}  // namespace sheen::field_coder
