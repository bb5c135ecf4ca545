// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/block_field.h"

#include <gtest/gtest.h>

namespace sheen {
namespace {

const Lattice kLattice{.origin = {1, 2, 3}, .cell = 0.5, .points = {17, 8, 9}};

TEST(BlockField, BlocksCoverThePoints) {
  const BlockField field(kLattice);
  EXPECT_TRUE((field.blocks() == Eigen::Array3i(3, 1, 2)).all());
  EXPECT_EQ(field.stored(), 0u);
  EXPECT_EQ(field.at({16, 7, 8}), BlockField::kFar);
  EXPECT_EQ(field.lattice().at({2, 0, 4}), Eigen::Vector3d(2, 2, 5));
}

TEST(BlockField, ABlockIsStoredAsItLay) {
  BlockField field(kLattice);
  field.fill({1, 0, 0}, true);
  EXPECT_TRUE(field.inside({1, 0, 0}));
  EXPECT_EQ(field.values({1, 0, 0}), nullptr);
  EXPECT_EQ(field.at({8, 0, 7}), -BlockField::kFar);
  field.store({1, 0, 0})[BlockField::number_in_block({0, 3, 7})] = 0.25f;
  field.store({2, 0, 1})[0] = -1;
  EXPECT_FALSE(field.inside({1, 0, 0}));
  EXPECT_EQ(field.at({8, 3, 7}), 0.25f);
  EXPECT_EQ(field.at({8, 3, 6}), -BlockField::kFar);
  EXPECT_EQ(field.at({16, 0, 8}), -1);
  EXPECT_EQ(field.at({7, 3, 7}), BlockField::kFar);
  EXPECT_EQ(field.values({1, 0, 0})[3 * 8 + 7 * 64], 0.25f);
  ASSERT_EQ(field.stored(), 2u);
  EXPECT_TRUE((field.stored_blocks()[1] == Eigen::Array3i(2, 0, 1)).all());
}

TEST(BlockField, ALatticeWithoutPointsHasNoBlocks) {
  EXPECT_EQ(BlockField({.points = {0, 5, -1}}).blocks().prod(), 0);
}

}  // namespace
}  // namespace sheen
