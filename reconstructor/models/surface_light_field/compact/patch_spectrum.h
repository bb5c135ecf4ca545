// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "reconstructor/models/surface_light_field/compact/compact_model.h"
#include "reconstructor/models/surface_light_field/compact/view_haar.h"

namespace sheen {

/// A surface map as it is stored: for each tile of each triangle's lattice luma and two colour differences, each its
/// frequencies from the smoothest on, in steps.
/// Bands, three for each tile, lie one behind the other: there are millions, and most of them are short.
class QuantisedMap {
 public:
  using Band = std::span<const std::int32_t>;  ///< as far as a value is not 0

  bool empty() const { return ends_.empty(); }
  bool is_zero() const { return values_.empty(); }
  Band band(std::size_t i) const {
    const std::size_t begin = i > 0 ? ends_[i - 1] : 0;
    return {values_.data() + begin, ends_[i] - begin};
  }
  void assign(std::span<const std::vector<std::int32_t>> bands);

 private:
  std::vector<std::int32_t> values_;
  std::vector<std::uint32_t> ends_;
};

struct QuantisedTerm {
  std::vector<std::int32_t> coefficients;  ///< Haar coefficients over the patch's images, in steps
  std::int32_t scale = 0;                  ///< of the map: half octaves of grey levels
  QuantisedMap map;                        ///< the basis, as large as it is seen
};

struct QuantisedPatch {
  bool known = false;  ///< any of its vertices is
  QuantisedMap mean;
  std::vector<QuantisedTerm> terms;
};

/// What is left out, which a reader need not know.
struct Rounding {
  float bit_price = 0.12f;   ///< squared steps that a bit is worth
  float least_term = 0.12f;  ///< part of a step that a term must add to the picture
};

/// `step`: of the surface maps, in grey levels (of 255). All maps have the same, so that every byte goes where it adds
/// most to the picture (reverse water-filling); coefficients have a finer one, a fixed part of it. Terms that add too
/// little for the step, and those behind them, are dropped.
/// `resolutions`: of the patch's triangles, in their order.
QuantisedPatch quantise(const Patch& patch, const std::vector<int>& resolutions, const ViewHaar::Plan& plan, float step,
                        const Rounding& rounding);

/// Mean, basis and coefficients; not the states.
Patch dequantise(const QuantisedPatch& quantised, const std::vector<int>& resolutions, const ViewHaar::Plan& plan,
                 float step);

}  // namespace sheen
