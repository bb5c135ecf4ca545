// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/svd_basis.h"

#include <gtest/gtest.h>

#include "tests/support/matchers.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

constexpr int kRows = 300, kColumns = 24;
constexpr double kTolerance = 0.01;

/// A basis of columns that were folded at once, and their coordinates in it.
struct Folded {
  SvdBasis<float> basis{kRows};
  Eigen::MatrixXf coordinates;

  explicit Folded(const Eigen::MatrixXf& columns) {
    Eigen::MatrixXf padded = Eigen::MatrixXf::Zero(row_panels::padded(kRows), columns.cols());
    padded.topRows(kRows) = columns;
    const int count = static_cast<int>(columns.cols());
    coordinates = basis
                      .fold({padded.data(), padded.rows(), count}, Eigen::VectorXd::Ones(count),
                            Eigen::MatrixXd::Zero(0, count), {}, {.tolerance = kTolerance})
                      .coordinates.cast<float>();
  }
  Eigen::MatrixXf columns() const { return basis.leading(basis.rank()) * coordinates; }
};

TEST(SvdBasis, TermsOfEightBitsAreOrthonormalAgainWhenItIsOpened) {
  Folded folded(patch_like_matrix(kRows, kColumns, 12, 0.01f, 3));
  const Eigen::MatrixXf before = folded.columns();
  const std::size_t open_bytes = folded.basis.bytes();
  folded.basis.close(kTolerance);
  const std::size_t values = static_cast<std::size_t>(kRows * folded.basis.rank());
  const auto packed = static_cast<double>(folded.basis.packed(5).bytes());
  EXPECT_NEAR(static_cast<double>(folded.basis.bytes(5)), packed, 0.02 * packed) << "but for rows that pad it";
  EXPECT_LT(folded.basis.bytes(), open_bytes - 2 * values - values / 2) << "half of the terms, at least";
  EXPECT_GT(orthogonality_loss(folded.basis.leading(folded.basis.rank())), 1e-4);

  folded.basis.open();
  EXPECT_LT(orthogonality_loss(folded.basis.leading(folded.basis.rank())), 1e-5);
  const double lost = (folded.columns() - before).cast<double>().squaredNorm(), energy = folded.basis.energy();
  EXPECT_LT(lost, 2e-3 * kTolerance * kTolerance * energy);
  EXPECT_GT(lost, 0);
}

TEST(SvdBasis, WithoutAToleranceAllTermsKeepSixteenBits) {
  Folded folded(patch_like_matrix(kRows, kColumns, 12, 0.01f, 3));
  const Eigen::MatrixXf before = folded.columns();
  folded.basis.close(0);
  EXPECT_EQ(folded.basis.packed(folded.basis.rank()).fine(), folded.basis.rank());
  EXPECT_LT((folded.columns() - before).norm(), 1e-4 * before.norm());
}

TEST(SvdBasis, OfOneTermNothingIsFaint) {
  Folded folded(Eigen::VectorXf::LinSpaced(kRows, 0.1f, 1) * Eigen::RowVectorXf::LinSpaced(kColumns, 0.5f, 1));
  ASSERT_EQ(folded.basis.rank(), 1);
  folded.basis.close(kTolerance);
  EXPECT_EQ(folded.basis.packed(1).fine(), 1);
}

}  // namespace
}  // namespace sheen
