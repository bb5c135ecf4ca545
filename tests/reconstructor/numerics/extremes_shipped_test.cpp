// SPDX-License-Identifier: Apache-2.0
// The factor as models keep it (`shipped_factor`). Truth is a formula, or the columns themselves; bounds are what
// rounding to its steps can do at most. Columns and 16-bit terms are whole multiples of a 32767th of their largest
// value, so each value is wrong by half of that; packing terms in 8 bits loses a thousandth of the tolerance's energy
// a fold.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <vector>

#include "common/image/color.h"
#include "reconstructor/numerics/shipped_factor.h"
#include "tests/support/matchers.h"
#include "tests/support/online_svd_checks.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using Eigen::MatrixXf;
using Eigen::VectorXf;

constexpr int kRows = 192;                 // 64 samples of three channels
constexpr double kHalfStep = 0.5 / 32767;  // over the largest value
constexpr double kLostToBytes = 1e-3;      // of the tolerance's energy, a fold
constexpr double kFloat = 1e-6;            // rounding of single precision, a fold

/// The radiances that a half float has, and far below what a camera sees.
constexpr float kRadiances[] = {1e-6f, 1e-4f, 1e-2f, 1, 1e2f, 65504};

OnlineSvdOptions shipped(double tolerance) {
  OnlineSvdOptions options = shipped_factor();
  options.tolerance = tolerance;
  return options;
}

/// Adds columns and follows what rounding may have done.
class Followed {
 public:
  explicit Followed(double tolerance) : factor_(kRows, shipped(tolerance)) {}

  void add(const VectorXf& column) {
    const double step = kHalfStep * static_cast<double>(column.cwiseAbs().maxCoeff());
    columns2_ += kRows * step * step;
    norm2_ += column.cast<double>().squaredNorm();
    factor_.add(column);
    if (factor_.pending() == 0) count_fold(factor_);
  }
  void add_all(const MatrixXf& columns) {
    for (Eigen::Index j = 0; j < columns.cols(); ++j) add(columns.col(j));
  }
  OnlineSvd settled() {
    const OnlineSvd all = factor_.settled();
    if (factor_.pending() > 0) count_fold(all);
    return all;
  }

  /// Of B Y, relative, by the triangle inequality: what each fold rounded adds up at worst.
  double rounding() const { return std::sqrt(columns2_ / norm2_) + terms_; }
  /// Of one entry of B^T B: two terms, rounded in each of the four rotations at most between two polishes.
  double orthogonality() const { return 4 * (2 * largest_ + largest_ * largest_); }

 private:
  void count_fold(const OnlineSvd& factor) {
    const MatrixXf basis = factor.basis();
    const double term = basis.size() == 0 ? 0
                                          : std::sqrt(static_cast<double>(kRows)) * kHalfStep *
                                                static_cast<double>(basis.cwiseAbs().maxCoeff());
    largest_ = std::max(largest_, term);
    terms_ += term + std::sqrt(kLostToBytes) * factor.options().tolerance + kFloat;
  }

  OnlineSvd factor_;
  double columns2_ = 0, norm2_ = 0, terms_ = 0, largest_ = 0;
};

/// Encoded colours of a patch of which the brightest has this radiance, seen from so many directions: of one more term
/// than `terms`.
MatrixXf glossy(float radiance, int views, int terms) {
  const MatrixXf colours = patch_like_matrix(kRows, views, terms, 0, 11);
  return srgb_encode(radiance) / colours.cwiseAbs().maxCoeff() * colours;
}

/// Orthogonal views of a patch of this many terms with these singular values.
struct KnownSpectrum {
  MatrixXf columns;
  Eigen::VectorXd singular_values;
};
KnownSpectrum of_known_spectrum(int views, const std::vector<double>& singular_values) {
  const auto terms = static_cast<int>(singular_values.size());
  const auto orthonormal = [terms](int rows, std::uint32_t seed) -> Eigen::MatrixXd {
    return Eigen::HouseholderQR<Eigen::MatrixXd>(gaussian_matrix(rows, terms, seed).cast<double>()).householderQ() *
           Eigen::MatrixXd::Identity(rows, terms);
  };
  const Eigen::VectorXd s = Eigen::Map<const Eigen::VectorXd>(singular_values.data(), terms);
  return {(orthonormal(kRows, 21) * s.asDiagonal() * orthonormal(views, 22).transpose()).cast<float>(), s};
}

TEST(Shipped, OneImageIsAsItWasButForTwoRoundings) {
  for (const float radiance : kRadiances) {
    const MatrixXf image = glossy(radiance, 1, 3);
    const OnlineSvd factor = settled_factor(image, shipped_factor());
    EXPECT_EQ(factor.rank(), 1);
    const MatrixXf shown = factor.displayed_basis() * factor.displayed_coefficients();
    EXPECT_LE((shown - image).cwiseAbs().maxCoeff() / image.maxCoeff(), 2 * kHalfStep + kFloat) << radiance;
  }
}

TEST(Shipped, EveryRadianceIsKeptAsFarAsTheToleranceAsks) {
  for (const double tolerance : {0.01, 0.0})
    for (const float radiance : kRadiances) {
      const MatrixXf images = glossy(radiance, 150, 4);
      Followed followed(tolerance);
      followed.add_all(images);
      const OnlineSvd factor = followed.settled();
      EXPECT_LE(displayed_model_error(factor, images), tolerance + followed.rounding()) << radiance;
      EXPECT_LE(orthogonality_lost(factor), followed.orthogonality()) << radiance;
      EXPECT_EQ(broken_invariants(factor), "") << radiance;
    }
}

TEST(Shipped, BesideTheBrightestRadianceTheDarkestIsAsFineAsAStepOfTheBrightest) {
  VectorXf image = glossy(1e-6f, 1, 3);
  image[30] = srgb_encode(65504);
  const OnlineSvd factor = settled_factor(image, shipped_factor());
  const VectorXf shown = factor.displayed_basis() * factor.displayed_coefficients();
  EXPECT_NEAR(shown[30] / image[30], 1, 2 * kHalfStep + kFloat);
  EXPECT_LE((shown - image).cwiseAbs().maxCoeff(), (2 * kHalfStep + kFloat) * image[30]);
  EXPECT_LT(2 * kHalfStep * image[30], 1 / 255.0);  // a grey level
}

TEST(Shipped, ImagesOfFewTermsHaveTheirSpectrumAndNothingBehindIt) {
  const std::vector<double> spectrum{20, 3, 0.8};
  const KnownSpectrum known = of_known_spectrum(200, spectrum);
  for (const double tolerance : {0.01, 0.0}) {
    Followed followed(tolerance);
    followed.add_all(known.columns);
    const OnlineSvd factor = followed.settled();
    const double bound = followed.rounding() * known.singular_values.norm();
    ASSERT_GE(factor.rank(), 3);
    for (Eigen::Index k = 0; k < 3; ++k)
      EXPECT_NEAR(std::sqrt(factor.spectrum()[k]), known.singular_values[k], bound + tolerance * 20) << k;
    EXPECT_LE(std::sqrt(factor.spectrum().tail(factor.rank() - 3).sum()), bound);
    if (tolerance > 0) EXPECT_EQ(factor.displayed_rank(), 3);
    EXPECT_LE(displayed_model_error(factor, known.columns), tolerance + followed.rounding());
    EXPECT_LE(orthogonality_lost(factor), followed.orthogonality());
  }
}

TEST(Shipped, ImagesThatDifferByLessThanAStepAreOneTermAsLongAsAllOfThem) {
  constexpr int kImages = 400;
  for (const float radiance : kRadiances) {
    const VectorXf image = glossy(radiance, 1, 3);
    const auto difference = static_cast<float>(0.1 * kHalfStep) * image.maxCoeff();
    MatrixXf images = image.replicate(1, kImages);
    images += (difference / 4) * gaussian_matrix(kRows, kImages, 31);
    Followed followed(0.01);
    followed.add_all(images);
    const OnlineSvd factor = followed.settled();
    EXPECT_EQ(factor.displayed_rank(), 1) << radiance;
    EXPECT_NEAR(std::sqrt(factor.spectrum()[0]) / images.cast<double>().norm(), 1, followed.rounding()) << radiance;
  }
}

/// Folds that leave a term where its steps have it must leave the views where they are, too.
TEST(Shipped, TheFirstViewsStayThroughTwoHundredThousandImages) {
  constexpr int kImages = 200'000, kPool = 257, kFirst = 40;
  constexpr double kTolerance = 0.01;
  const MatrixXf pool = patch_like_matrix(kRows, kPool, 4, 0.009f, 4);
  OnlineSvd factor(kRows, shipped(kTolerance));
  for (int i = 0; i < kImages; ++i) {
    factor.add(pool.col(i % kPool));
    while (factor.folded_views() > 2 * kFirst) factor.merge_views(kFirst, kFirst + 1);
  }
  const OnlineSvd settled = factor.settled();
  const MatrixXf shown = settled.displayed_basis() * settled.displayed_coefficients().leftCols(kFirst);
  EXPECT_LE((shown - pool.leftCols(kFirst)).norm() / pool.leftCols(kFirst).norm(), kTolerance);
  EXPECT_EQ(broken_invariants(settled), "");
}

/// What is most probable misses the visible values by no more than the truth does, in units of the noise, and the
/// truth's own distance from the prior: one a term.
TEST(Shipped, WhatHalfHiddenImagesShowIsMissedByLessThanTheNoise) {
  constexpr int kHalf = kRows / 2;
  constexpr double kTolerance = 0.01;
  for (const float radiance : kRadiances) {
    const MatrixXf images = glossy(radiance, 120, 4);
    OnlineSvd factor(kRows, shipped(kTolerance));
    for (Eigen::Index j = 0; j < images.cols(); ++j) {
      std::vector<std::uint8_t> known(kRows, 1);
      if (j % 2 == 1) std::fill_n(known.begin() + (j % 4 == 1 ? 0 : kHalf), kHalf, 0);
      factor.add(images.col(j), known);
    }
    const OnlineSvd settled = factor.settled();
    const MatrixXf shown = settled.displayed_basis() * settled.displayed_coefficients();
    ASSERT_TRUE(shown.allFinite());
    double missed2 = 0, values = 0;
    for (Eigen::Index j = 1; j < images.cols(); j += 2, values += kHalf)
      missed2 += (shown - images).col(j).segment(j % 4 == 1 ? kHalf : 0, kHalf).squaredNorm();
    const double tolerated2 = kTolerance * kTolerance * images.squaredNorm() / static_cast<double>(images.size());
    EXPECT_LE(missed2 / values, settled.row_noise() * settled.rank() / kHalf + tolerated2) << radiance;
    EXPECT_LE(shown.cwiseAbs().maxCoeff(), 2 * images.maxCoeff()) << radiance;
    EXPECT_EQ(broken_invariants(settled), "") << radiance;
  }
}

}  // namespace
}  // namespace sheen
