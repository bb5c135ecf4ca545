// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "reconstructor/light_field_file/compact_model.h"
#include "reconstructor/light_field_file/view_haar.h"

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

/// Mean, basis and coefficients; not the states.
/// `step`: of the surface maps, in grey levels (of 255). All maps have the same; coefficients have a finer one, a fixed
/// part of it. `resolutions`: of the patch's triangles, in their order.
Patch dequantise(const QuantisedPatch& quantised, const std::vector<int>& resolutions, const ViewHaar::Plan& plan,
                 float step);

// What a writer needs, too:

/// What a rounded value stands for, in steps. Values are rarer, the larger they are: it is above the size that rounding
/// prefers.
float rounded_value(std::int32_t value);
/// Of a coefficient.
float coefficient_value(std::int32_t value);
/// Step of a patch's coefficients, of so many images and rows of its maps.
float coefficient_step(float step, Eigen::Index images, Eigen::Index rows);
/// How large a map is that a term of this scale has, RMS in grey levels.
float size_of_scale(std::int32_t scale);
/// Rows 3 * sample + channel, in grey levels.
void dequantise_map(const QuantisedMap& map, const std::vector<int>& resolutions, float step,
                    Eigen::Ref<Eigen::VectorXf> values);

/// Frequencies of a map's tiles, a block of rows after the other: their number of rows each, luma and two differences.
/// The levels of the tiles, their first frequencies, differ little: joined two and two again and again, by the
/// unbalanced Haar transform, most of them is in one number, the first tile's.
struct MapFrequencies {
  std::vector<Eigen::MatrixX3f> tiles;
  std::vector<std::size_t> sizes;  ///< samples of each tile

  void join_levels();
  void part_levels();
};

}  // namespace sheen
