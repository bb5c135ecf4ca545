// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/sign_blocks.h"

#include <algorithm>
#include <bit>

namespace sheen {
namespace {

constexpr int kSide = SignBlocks::kSide;

SignBlocks::Rows negative(const float* values) {
  SignBlocks::Rows rows;
  for (std::uint8_t& row : rows) {
    row = 0;
    for (int x = 0; x < kSide; ++x) row |= static_cast<std::uint8_t>((values[x] < 0) << x);
    values += kSide;
  }
  return rows;
}

/// Along one axis: which points of a block are of the lattice, and which of these are not its border.
struct Extent {
  Extent(int block, int points) {
    for (int i = 0; i < kSide; ++i) {
      const int point = kSide * block + i;
      lattice |= (point < points) << i;
      within |= (point > 0 && point < points - 1) << i;
    }
  }
  unsigned lattice = 0, within = 0;
};

}  // namespace

SignBlocks::SignBlocks(const BlockField& field)
    : blocks_(field.blocks()),
      stride_{1, std::size_t(blocks_.x()) + 1, (std::size_t(blocks_.x()) + 1) * (std::size_t(blocks_.y()) + 1)},
      table_(stride_[2] * (std::size_t(blocks_.z()) + 1), kOutside) {
  for_each_block([&](std::size_t number) {
    const Eigen::Array3i block = block_of(number);
    const float* values = field.values(block);
    const bool on_border = (block == 0).any() || (kSide * (block + 1) >= field.lattice().points).any();
    if (values) {
      set_rows(block, negative(values), field.lattice().points);
    } else if (field.inside(block)) {
      fill(number, true);
      if (on_border) {
        Rows full;
        full.fill(0xff);
        set_rows(block, full, field.lattice().points);
      }
    }
  });
}

void SignBlocks::set_rows(const Eigen::Array3i& block, Rows rows, const Eigen::Array3i& points) {
  const Extent x(block.x(), points.x()), y(block.y(), points.y()), z(block.z(), points.z());
  std::uint8_t any = 0, all = 0xff;
  for (int row = 0; row < kSide * kSide; ++row) {
    const int j = row % kSide, k = row / kSide;
    const unsigned lattice = (y.lattice >> j & z.lattice >> k & 1) * x.lattice,
                   within = (y.within >> j & z.within >> k & 1) * x.within;
    forced_outside_ += std::popcount(rows[row] & lattice & ~within);
    rows[row] &= within;
    any |= rows[row];
    all &= rows[row];
  }
  if (any == 0 || all == 0xff) return fill(number_of(block), any != 0);
  table_[number_of(block)] = static_cast<std::int32_t>(rows_.size());
  rows_.push_back(rows);
}

bool SignBlocks::of_one_sign(std::size_t number) const {
  const std::int32_t sign = table_[number];
  if (sign >= 0) return false;
  for (int corner = 1; corner < 8; ++corner)
    if (table_[holder(number, (corner & 1) * kSide, (corner >> 1 & 1) * kSide, (corner >> 2) * kSide)] != sign)
      return false;
  return true;
}

SignBlocks::WideRows SignBlocks::wide_rows(std::size_t number) const {
  const auto row_of = [&](std::size_t block, int row) -> unsigned {
    const Rows* stored = rows(block);
    return stored ? (*stored)[row] : inside(block) ? 0xffu : 0u;
  };
  WideRows wide;
  for (int z = 0; z <= kSide; ++z)
    for (int y = 0; y <= kSide; ++y) {
      const int row = y % kSide + kSide * (z % kSide);
      const unsigned here = row_of(holder(number, 0, y, z), row), next = row_of(holder(number, kSide, y, z), row);
      wide[y + (kSide + 1) * z] = static_cast<std::uint16_t>(here | (next & 1) << kSide);
    }
  return wide;
}

}  // namespace sheen
