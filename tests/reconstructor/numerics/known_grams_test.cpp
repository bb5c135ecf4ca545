// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/known_grams.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>
#include <vector>

namespace sheen {
namespace {

using Patterns = std::vector<std::uint64_t>;

std::uint64_t first_bits(int count) {
  return count == kPatternColumns ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

/// Row by row, as the definition has it.
template <typename Scalar>
Eigen::MatrixXd by_definition(const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>& basis,
                              const Patterns& hidden, int column) {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(basis.cols(), basis.cols());
  for (std::size_t row = 0; row < hidden.size(); ++row) {
    if (hidden[row] >> column & 1) continue;
    const Eigen::VectorXd b = basis.row(static_cast<Eigen::Index>(row)).transpose().template cast<double>();
    gram += b * b.transpose();
  }
  return gram;
}

template <typename Scalar>
void expect_as_defined(int rank, int columns, const Patterns& hidden, double tolerance) {
  const auto rows = static_cast<Eigen::Index>(hidden.size());
  std::srand(static_cast<unsigned>(rank));
  const Eigen::MatrixXd random = Eigen::MatrixXd::Random(rows, rank);
  const Eigen::MatrixXd orthonormal = random.householderQr().householderQ() * Eigen::MatrixXd::Identity(rows, rank);
  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> basis(row_panels::padded(rows), rank);
  basis.setZero();
  basis.topRows(rows) = orthonormal.cast<Scalar>();
  const Eigen::MatrixXd grams = known_grams<Scalar>(row_panels::columns(basis, rank), hidden, columns);
  ASSERT_EQ(grams.cols(), columns);
  for (int j = 0; j < columns; ++j)
    EXPECT_LT((grams.col(j).reshaped(rank, rank) - by_definition(basis, hidden, j)).cwiseAbs().maxCoeff(), tolerance)
        << "rank " << rank << ", column " << j << " of " << columns;
}

void expect_as_defined(int rank, int columns, const Patterns& hidden) {
  expect_as_defined<float>(rank, columns, hidden, 3e-7);
  expect_as_defined<double>(rank, columns, hidden, 1e-14);
}

TEST(KnownGrams, SamplesHiddenAtRandomFewAndMany) {
  std::mt19937 random(1);
  for (const int columns : {1, 3, 17, 63, 64})
    for (const double fraction : {0.03, 0.5, 0.97}) {
      std::bernoulli_distribution hides(fraction);
      Patterns hidden(601);
      for (std::size_t row = 0; row < hidden.size(); ++row) {
        if (row % 3 != 0) {  // a sample has three channels
          hidden[row] = hidden[row - 1];
          continue;
        }
        for (int j = 0; j < columns; ++j) hidden[row] |= std::uint64_t{hides(random)} << j;
      }
      expect_as_defined(14, columns, hidden);
    }
}

TEST(KnownGrams, RanksBesideThoseOfWholeRegisters) {
  Patterns hidden(200);
  for (std::size_t row = 0; row < hidden.size(); ++row) hidden[row] = row * 0x9e3779b97f4a7c15 & first_bits(20);
  for (const int rank : {1, 2, 7, 8, 9, 15, 16, 17, 31, 32, 33, 48}) expect_as_defined(rank, 20, hidden);
}

TEST(KnownGrams, OnePatternOfManyRowsInSeveralRuns) {
  Patterns hidden(3000, 0);
  for (std::size_t row = 0; row < hidden.size(); ++row) hidden[row] = row % 1000 < 700 ? 0b01 : 0b10;
  expect_as_defined(12, 2, hidden);
}

TEST(KnownGrams, ColumnsThatHideNothingAndAll) {
  expect_as_defined(5, 3, Patterns(100, 0));
  expect_as_defined(5, 3, Patterns(100, 0b111));
  expect_as_defined(5, kPatternColumns, Patterns(100, ~std::uint64_t{0} << 1));
}

}  // namespace
}  // namespace sheen
