// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/block_field.h"

namespace sheen {

BlockField::BlockField(const Lattice& lattice)
    : lattice_(lattice),
      blocks_((lattice.points.max(0) + (kSide - 1)) / kSide),
      table_(blocks_.cast<std::size_t>().prod(), kOutside) {}

float* BlockField::store(const Eigen::Array3i& block) {
  std::int32_t& place = table_[number_of(block)];
  if (place < 0) {
    values_.resize(values_.size() + kBlockPoints, place == kInside ? -kFar : kFar);
    place = static_cast<std::int32_t>(stored_.size());
    stored_.push_back(block);
  }
  return values_.data() + std::size_t(place) * kBlockPoints;
}

}  // namespace sheen
