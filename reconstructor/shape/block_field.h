// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sheen {

/// Points of a cubic lattice: number (x, y, z) lies at origin + cell (x, y, z).
struct Lattice {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double cell = 0;  ///< metres
  Eigen::Array3i points = Eigen::Array3i::Zero();

  Eigen::Vector3d at(const Eigen::Array3i& point) const { return origin + cell * point.cast<double>().matrix(); }
};

/// A signed distance per point of a lattice, metres, negative inside, in blocks of kSide^3 points. Only blocks near the
/// surface are stored; any other lies wholly outside or wholly inside. The last blocks of an axis may reach beyond the
/// lattice: values there mean nothing.
class BlockField {
 public:
  static constexpr int kSide = 8;
  static constexpr int kBlockPoints = kSide * kSide * kSide;
  static constexpr float kFar = 1e9f;

  explicit BlockField(const Lattice& lattice);  ///< all outside

  const Lattice& lattice() const { return lattice_; }
  const Eigen::Array3i& blocks() const { return blocks_; }  ///< per axis

  /// The values of a block, x fastest, then y. Stores it first where it is not, at +-kFar as it lay. Valid until
  /// another block is stored.
  float* store(const Eigen::Array3i& block);
  /// Null where it is not stored. Valid until another block is stored.
  float* values(const Eigen::Array3i& block) {
    const std::int32_t place = table_[number_of(block)];
    return place < 0 ? nullptr : values_.data() + std::size_t(place) * kBlockPoints;
  }
  const float* values(const Eigen::Array3i& block) const { return const_cast<BlockField*>(this)->values(block); }

  /// Lays a block that is not stored wholly inside or outside.
  void fill(const Eigen::Array3i& block, bool inside) { table_[number_of(block)] = inside ? kInside : kOutside; }
  /// Not stored, and wholly inside.
  bool inside(const Eigen::Array3i& block) const { return table_[number_of(block)] == kInside; }

  /// The value of a point of the lattice: +-kFar where its block is not stored.
  float at(const Eigen::Array3i& point) const {
    const Eigen::Array3i block = point / kSide;
    const float* stored = values(block);
    return stored ? stored[number_in_block(point - kSide * block)] : inside(block) ? -kFar : kFar;
  }

  /// Where a point stands among its block's values, by its place from the block's first point.
  static int number_in_block(const Eigen::Array3i& place) {
    return place.x() + kSide * (place.y() + kSide * place.z());
  }

  std::size_t stored() const { return stored_.size(); }                      ///< number of blocks
  std::span<const Eigen::Array3i> stored_blocks() const { return stored_; }  ///< in the order of storing
  std::size_t bytes() const {
    return values_.capacity() * sizeof(float) + table_.capacity() * sizeof(std::int32_t) +
           stored_.capacity() * sizeof(Eigen::Array3i);
  }

 private:
  static constexpr std::int32_t kOutside = -1, kInside = -2;

  std::size_t number_of(const Eigen::Array3i& block) const {
    return block.x() + std::size_t(blocks_.x()) * (block.y() + std::size_t(blocks_.y()) * block.z());
  }

  Lattice lattice_;
  Eigen::Array3i blocks_;
  std::vector<std::int32_t> table_;  ///< per block its place among the stored, or kOutside or kInside
  std::vector<float> values_;
  std::vector<Eigen::Array3i> stored_;
};

}  // namespace sheen
