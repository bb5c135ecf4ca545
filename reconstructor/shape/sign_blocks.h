// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "reconstructor/shape/block_field.h"

namespace sheen {

/// Which points of a lattice lie inside, a bit each, in the blocks of a field. Blocks are told by their number in a
/// table that has one more layer of blocks, outside, on the three upper sides: every block of the field has all
/// neighbours there.
class SignBlocks {
 public:
  static constexpr int kSide = BlockField::kSide;
  /// Of a block: bit x of row y + kSide z.
  using Rows = std::array<std::uint8_t, kSide * kSide>;
  /// Of a block and what follows it on its upper sides: bit x of row y + (kSide + 1) z.
  using WideRows = std::array<std::uint16_t, (kSide + 1) * (kSide + 1)>;

  /// Inside are the points of negative value, but for those of the lattice's border. NaN is outside.
  explicit SignBlocks(const BlockField& field);

  std::size_t forced_outside() const { return forced_outside_; }  ///< points of the border with a negative value

  /// Calls `each(number)` for the blocks of the field, x fastest.
  template <typename Each>
  void for_each_block(const Each& each) const {
    for (int z = 0; z < blocks_.z(); ++z)
      for (int y = 0; y < blocks_.y(); ++y)
        for (int x = 0; x < blocks_.x(); ++x) each(number_of({x, y, z}));
  }
  std::size_t numbers() const { return table_.size(); }  ///< with the layer outside
  std::size_t number_of(const Eigen::Array3i& block) const {
    return block.x() + stride_[1] * block.y() + stride_[2] * block.z();
  }
  Eigen::Array3i block_of(std::size_t number) const {
    return {static_cast<int>(number % stride_[1]), static_cast<int>(number % stride_[2] / stride_[1]),
            static_cast<int>(number / stride_[2])};
  }

  /// The block that holds a point, 0 to kSide from the first point of a block of the field.
  std::size_t holder(std::size_t number, int x, int y, int z) const {
    return number + x / kSide * stride_[0] + y / kSide * stride_[1] + z / kSide * stride_[2];
  }

  /// Null where all its points have one sign, and nothing else is stored.
  const Rows* rows(std::size_t number) const { return table_[number] < 0 ? nullptr : &rows_[table_[number]]; }
  Rows* rows(std::size_t number) { return table_[number] < 0 ? nullptr : &rows_[table_[number]]; }
  bool inside(std::size_t number) const { return table_[number] == kInside; }  ///< of a block without rows
  void fill(std::size_t number, bool inside) { table_[number] = inside ? kInside : kOutside; }  ///< the same

  /// Whether the block and the seven that follow it on its upper sides are of one sign.
  bool of_one_sign(std::size_t number) const;
  WideRows wide_rows(std::size_t number) const;

 private:
  static constexpr std::int32_t kOutside = -1, kInside = -2;

  void set_rows(const Eigen::Array3i& block, Rows rows, const Eigen::Array3i& points);

  Eigen::Array3i blocks_;
  std::array<std::size_t, 3> stride_;
  std::vector<std::int32_t> table_;  ///< the number of a block's rows, or kOutside or kInside
  std::vector<Rows> rows_;
  std::size_t forced_outside_ = 0;
};

}  // namespace sheen
