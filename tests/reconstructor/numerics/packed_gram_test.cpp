// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/packed_gram.h"

#include <gtest/gtest.h>

namespace sheen {
namespace {

Eigen::MatrixXd symmetric(Eigen::Index size) {
  const Eigen::MatrixXd any = Eigen::MatrixXd::Random(size, size);
  return any + any.transpose();
}

TEST(PackedGram, GivesBackWhatItWasMadeOfToTheBit) {
  for (const Eigen::Index size : {1, 2, 5, 24})
    for (Eigen::Index block = 0; block <= size; ++block) {
      Eigen::MatrixXd gram = Eigen::VectorXd::Random(size).asDiagonal();
      gram.topLeftCorner(block, block) = symmetric(block);
      const PackedGram packed(gram, block);
      EXPECT_EQ(packed.unpacked(), gram) << size << " " << block;
      EXPECT_EQ(packed.diagonal(), Eigen::VectorXd(gram.diagonal()));
      EXPECT_EQ(packed.bytes(), sizeof(double) * static_cast<std::size_t>(block * (block + 1) / 2 + size - block));
    }
}

TEST(PackedGram, KeepsWhatIsNotDiagonalBehindItsBlock) {
  const Eigen::MatrixXd gram = symmetric(7);
  const PackedGram packed(gram, 3);
  EXPECT_EQ(packed.unpacked(), gram);
  EXPECT_EQ(packed.diagonal(), Eigen::VectorXd(gram.diagonal()));
}

TEST(PackedGram, OfTwoTrianglesThatRoundingHasToldApartTheLowerOneIsKept) {
  Eigen::MatrixXd gram = symmetric(4);
  gram(1, 3) += 1e-15;
  const Eigen::MatrixXd unpacked = PackedGram(gram, 4).unpacked();
  EXPECT_EQ(unpacked(3, 1), gram(3, 1));
  EXPECT_EQ(unpacked(1, 3), gram(3, 1));
}

TEST(PackedGram, IsEmptyWithoutAMatrix) {
  EXPECT_TRUE(PackedGram().empty());
  EXPECT_EQ(PackedGram(Eigen::MatrixXd(), 0).unpacked().size(), 0);
}

}  // namespace
}  // namespace sheen
