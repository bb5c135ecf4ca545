// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/self_test.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "reconstructor/numerics/batch_pca.h"
#include "reconstructor/numerics/shipped_factor.h"

namespace sheen {
namespace {

using Eigen::MatrixXf;
using Eigen::VectorXf;

constexpr int kRows = 192;  // 64 samples of three channels

/// The same numbers on every machine: the standard's distributions are not.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed) {}

  /// Mean 0, variance 1: a sum of uniform numbers, near enough to a normal one.
  float operator()() {
    constexpr int kTerms = 12;
    float sum = -kTerms / 2.0f;
    for (int i = 0; i < kTerms; ++i) sum += uniform();
    return sum;
  }
  MatrixXf matrix(int rows, int columns) {
    return MatrixXf::NullaryExpr(rows, columns, [this] { return (*this)(); });
  }

 private:
  float uniform() {
    state_ = 6364136223846793005u * state_ + 1442695040888963407u;
    return static_cast<float>(state_ >> 40) / static_cast<float>(1u << 24);
  }
  std::uint64_t state_;
};

/// Encoded colours of a patch seen from so many directions: a mean, terms of falling size, and a camera's noise.
MatrixXf patch_columns(int columns, int terms, std::uint64_t seed) {
  Noise noise(seed);
  MatrixXf data =
      (0.5f + 0.1f * noise.matrix(kRows, 1).array()).matrix() * (1 + 0.1f * noise.matrix(1, columns).array()).matrix();
  float size = 0.1f;
  for (int t = 0; t < terms; ++t, size *= 0.6f)
    data += size * (noise.matrix(kRows, 1) * noise.matrix(1, columns)).eval();
  return data + std::sqrt(static_cast<float>(kCameraVariance)) * noise.matrix(kRows, columns);
}

/// The same where nothing may be lost: then it holds its most terms, all of 16 bits.
OnlineSvdOptions without_tolerance() {
  OnlineSvdOptions options = shipped_factor();
  options.tolerance = 0;
  return options;
}

OnlineSvd factor_of(const MatrixXf& columns, const OnlineSvdOptions& options = shipped_factor()) {
  OnlineSvd factor(kRows, options);
  for (Eigen::Index j = 0; j < columns.cols(); ++j) factor.add(columns.col(j));
  return factor.settled();
}

/// Relative, Frobenius: of what is displayed.
double displayed_error(const OnlineSvd& factor, const MatrixXf& columns) {
  const MatrixXf shown = factor.displayed_basis() * factor.displayed_coefficients();
  return static_cast<double>((columns - shown).norm()) / static_cast<double>(columns.norm());
}

void near_duplicates(std::vector<NumericsCheck>& checks) {
  constexpr int kColumns = 20000, kViews = 64;
  const VectorXf column = patch_columns(1, 3, 1);
  Noise noise(2);
  const MatrixXf pool = column.replicate(1, 257) + 1e-4f * noise.matrix(kRows, 257);
  OnlineSvd factor(kRows, without_tolerance());
  std::vector<double> times(257, 0);
  double lost = 0;
  for (int i = 0; i < kColumns; ++i) {
    factor.add(pool.col(i % 257));
    times[static_cast<std::size_t>(i % 257)] += 1;
    while (factor.folded_views() > kViews) factor.merge_views(0, 1);
    if (i % 2000 == 0) lost = std::max(lost, orthogonality_lost(factor));
  }
  factor.fold();
  const double first = batch_pca(pool, 1, times).singular_values[0];
  checks.push_back({"20,000 near-duplicates: orthogonality lost", std::max(lost, orthogonality_lost(factor)), 2e-3});
  checks.push_back({"20,000 near-duplicates: first singular value off by",
                    std::abs(std::sqrt(factor.spectrum()[0]) / first - 1), 1e-4});
}

void repetition(std::vector<NumericsCheck>& checks) {
  const VectorXf column = patch_columns(1, 3, 3);
  const OnlineSvd repeated = factor_of(column.replicate(1, 500));
  checks.push_back({"a column 500 times: terms beyond one", std::abs(repeated.rank() - 1.0), 0});
  checks.push_back({"a column 500 times: error", displayed_error(repeated, column.replicate(1, 500)), 1e-4});
  checks.push_back({"nothing but zeros: terms", static_cast<double>(factor_of(MatrixXf::Zero(kRows, 30)).rank()), 0});
}

void drift(std::vector<NumericsCheck>& checks) {
  constexpr int kColumns = 6000, kOld = 40;
  const MatrixXf pool = patch_columns(257, 4, 4);
  OnlineSvd factor(kRows, shipped_factor());
  for (int i = 0; i < kColumns; ++i) {
    factor.add(pool.col(i % 257));
    while (factor.folded_views() > 2 * kOld) factor.merge_views(kOld, kOld + 1);
  }
  const OnlineSvd now = factor.settled();
  const MatrixXf old = now.displayed_basis() * now.displayed_coefficients().leftCols(kOld);
  checks.push_back({"the first 40 views after 6,000: off by",
                    static_cast<double>((old - pool.leftCols(kOld)).norm() / pool.leftCols(kOld).norm()), 0.02});
}

void orders(std::vector<NumericsCheck>& checks) {
  const MatrixXf data = patch_columns(150, 10, 5);
  std::vector<int> rising(150);
  std::iota(rising.begin(), rising.end(), 0);
  std::sort(rising.begin(), rising.end(),
            [&](int a, int b) { return data.col(a).squaredNorm() < data.col(b).squaredNorm(); });
  const std::vector<int> falling(rising.rbegin(), rising.rend());
  double worst = 0;
  for (const std::vector<int>& order : {rising, falling}) {
    const MatrixXf columns = data(Eigen::all, order);
    const OnlineSvd factor = factor_of(columns);
    worst =
        std::max(worst, displayed_error(factor, columns) / batch_pca(columns, factor.displayed_rank()).relative_error);
  }
  checks.push_back({"sorted columns: error over that of a batch SVD of as many terms", worst, 1.05});
  const OnlineSvd every_term = factor_of(data, without_tolerance());
  checks.push_back({"no tolerance: orthogonality lost", orthogonality_lost(every_term), 2e-3});
  checks.push_back({"no tolerance: error over that of a batch SVD of as many terms",
                    displayed_error(every_term, data) / batch_pca(data, every_term.displayed_rank()).relative_error,
                    1.05});
  checks.push_back({"values a thousand times as large: error over that of the values as they are",
                    displayed_error(factor_of(1e3f * data), 1e3f * data) / displayed_error(factor_of(data), data),
                    1.05});
}

void highlight(std::vector<NumericsCheck>& checks) {
  MatrixXf data = patch_columns(60, 3, 6);
  data(30, 33) *= 1e3f;
  const OnlineSvd factor = factor_of(data);
  const VectorXf shown = factor.displayed_basis() * factor.displayed_coefficients().col(33);
  checks.push_back({"a highlight of a thousand times the patch: off by",
                    static_cast<double>(std::abs(shown[30] / data(30, 33) - 1)), 1e-4});
}

void hidden(std::vector<NumericsCheck>& checks) {
  const MatrixXf data = patch_columns(80, 3, 7);
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  OnlineSvd damaged(kRows, shipped_factor()), masked(kRows, shipped_factor());
  for (Eigen::Index j = 0; j < data.cols(); ++j) {
    VectorXf column = data.col(j);
    std::vector<std::uint8_t> known(kRows, 1);
    for (int row = static_cast<int>(j) % 7; row < kRows; row += 7) {
      column[row] = row % 2 == 0 ? nan : infinite;
      known[static_cast<std::size_t>(row)] = 0;
    }
    damaged.add(column);
    masked.add(data.col(j), known);
  }
  const OnlineSvd a = damaged.settled(), b = masked.settled();
  const bool same = a.rank() == b.rank() && a.basis() == b.basis() && a.coefficients() == b.coefficients();
  checks.push_back({"NaN and infinity: values that differ from those of hidden rows", same ? 0.0 : 1.0, 0});

  OnlineSvd factor = factor_of(data.leftCols(60));
  std::vector<std::uint8_t> one(kRows, 0);
  one[17] = 1;
  factor.add(data.col(70), one);
  const OnlineSvd settled = factor.settled();
  const VectorXf guess = settled.displayed_basis() * settled.displayed_coefficients().col(60);
  checks.push_back({"one visible row: error over that of black",
                    static_cast<double>((guess - data.col(70)).norm() / data.col(70).norm()), 0.6});
}

/// Every other column shows one half of the rows or the other.
void occlusion(std::vector<NumericsCheck>& checks) {
  const MatrixXf data = patch_columns(120, 5, 10);
  OnlineSvd factor(kRows, shipped_factor());
  for (Eigen::Index j = 0; j < data.cols(); ++j) {
    std::vector<std::uint8_t> known(kRows, 1);
    if (j % 2 == 1) std::fill_n(known.begin() + (j % 4 == 1 ? 0 : kRows / 2), kRows / 2, 0);
    factor.add(data.col(j), known);
  }
  checks.push_back({"half of the columns half hidden: error, hidden rows included, over that of whole columns",
                    displayed_error(factor.settled(), data) / displayed_error(factor_of(data), data), 1.5});
}

void removal(std::vector<NumericsCheck>& checks) {
  MatrixXf data = patch_columns(120, 6, 8);
  Noise noise(9);
  data.col(20) = 0.5f * noise.matrix(kRows, 1);  // something else in the picture
  MatrixXf rest(kRows, data.cols() - 1);
  rest << data.leftCols(20), data.rightCols(data.cols() - 21);
  OnlineSvd factor = factor_of(data);
  factor.remove(20);
  checks.push_back({"an image removed long after: error over that of never having seen it",
                    displayed_error(factor, rest) / displayed_error(factor_of(rest), rest), 1.05});
}

}  // namespace

std::vector<NumericsCheck> numerics_self_test() {
  std::vector<NumericsCheck> checks;
  near_duplicates(checks);
  repetition(checks);
  drift(checks);
  orders(checks);
  highlight(checks);
  hidden(checks);
  occlusion(checks);
  removal(checks);
  return checks;
}

}  // namespace sheen
