// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>
#include <time.h>

#include <Eigen/SVD>

#include "reconstructor/numerics/batch_pca.h"
#include "reconstructor/numerics/row_panels.h"
#include "tests/bench/numerics_rows.h"
#include "tests/support/plain_brand.h"
#include "tests/support/test_patches.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPatches = 3500;
constexpr int kFullAfter = 60;  // columns until every rank has reached its cap

/// Seconds that this thread was given: what shares the processor does not count.
double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

OnlineSvdOptions capped_at(int internal_rank) {
  return {.max_rank = kDisplayed, .internal_rank = internal_rank, .tolerance = 0};
}

/// Microseconds of processor time per column once the rank is full: median of runs over 240 columns of one patch.
template <typename Scalar>
double us_per_column(const Eigen::MatrixXf& columns, int internal_rank) {
  const auto data = columns.cast<Scalar>().eval();
  std::vector<double> us;
  for (int run = 0; run < 21; ++run) {
    BasicOnlineSvd<Scalar> factor(static_cast<int>(data.rows()), capped_at(internal_rank));
    for (int j = 0; j < kFullAfter; ++j) factor.add(data.col(j));
    const double start = thread_seconds();
    for (Eigen::Index j = kFullAfter; j < data.cols(); ++j) factor.add(data.col(j));
    us.push_back(1e6 * (thread_seconds() - start) / static_cast<double>(data.cols() - kFullAfter));
  }
  return quantile(us, 0.5);
}

constexpr int kChains = 12;  // of multiply-adds that do not wait for each other: enough to fill the pipeline

/// On its own, for the sums must stay in registers.
[[gnu::noinline]] row_panels::Vector<float> multiply_and_add(float factor, int steps) {
  row_panels::Vector<float> sums[kChains] = {};
  for (int c = 0; c < kChains; ++c) sums[c] += static_cast<float>(c);  // alike, they would be computed once
  for (int step = 0; step < steps; ++step)
#pragma GCC unroll 12
    for (int c = 0; c < kChains; ++c) sums[c] = sums[c] * factor + factor;
  for (int c = 1; c < kChains; ++c) sums[0] += sums[c];
  return sums[0];
}

/// Multiply-adds of single precision a microsecond of processor time, from registers alone: what this thread could
/// reach.
double peak_multiply_adds_per_us() {
  constexpr int kSteps = 20000;
  std::vector<double> rates;
  double used = 0;  // else there would be nothing to compute
  for (int run = 0; run < 51; ++run) {
    const double start = thread_seconds();
    used += multiply_and_add(0.999f, kSteps)[0];
    const double count = 1.0 * kChains * kSteps * row_panels::VectorOf<float>::kLanes;
    rates.push_back(1e-6 * count / (thread_seconds() - start));
  }
  return used > 0 ? quantile(rates, 0.5) : 0;
}

/// Microseconds a column of the products with the rows at that rate: projecting a block of n columns on a basis of r
/// (3 r n, residuals and what they have left over included), Gram matrices of residuals and, every fourth time, basis,
/// and the rotation of both (r (r + n)).
double row_products_us(Eigen::Index rows, int r, double multiply_adds_per_us) {
  const int n = OnlineSvdOptions{}.block;
  const double a_row = 3.0 * r * n + 0.5 * n * n + 0.125 * r * r + 1.0 * r * (r + n);
  return static_cast<double>(rows) * a_row / n / multiply_adds_per_us;
}

double brand_us_per_column(const Eigen::MatrixXf& columns, int cap) {
  PlainBrand brand(static_cast<int>(columns.rows()), {.cap = cap});
  for (int j = 0; j < kFullAfter; ++j) brand.add(columns.col(j).cast<double>());
  const double start = thread_seconds();
  for (Eigen::Index j = kFullAfter; j < columns.cols(); ++j) brand.add(columns.col(j).cast<double>());
  return 1e6 * (thread_seconds() - start) / static_cast<double>(columns.cols() - kFullAfter);
}

/// Milliseconds of each image that all patches see, once their ranks are full.
std::vector<double> ms_per_image(const Eigen::MatrixXf& columns, int internal_rank, int images, bool parallel) {
  std::vector<OnlineSvd> patches;
  patches.reserve(kPatches);
  for (unsigned r = 0; r < kPatches; ++r)
    patches.emplace_back(static_cast<int>(columns.rows()), capped_at(internal_rank), r);
  std::vector<double> ms;
  for (int i = -kFullAfter; i < images; ++i) {
    const auto fold = [&](int r) { patches[r].add(columns.col((7 * r + i + kFullAfter) % columns.cols())); };
    const auto start = Clock::now();
    if (parallel || i < 0)
      tbb::parallel_for(0, kPatches, fold);
    else
      for (int r = 0; r < kPatches; ++r) fold(r);
    if (i >= 0) ms.push_back(1e3 * seconds_since(start));
  }
  return ms;
}

/// A tenth of the patches, which is more than a cache holds too.
double brand_ms_per_image(const Eigen::MatrixXf& columns) {
  std::vector<PlainBrand> patches(kPatches / 10, PlainBrand(static_cast<int>(columns.rows()), {.cap = kDisplayed}));
  const auto image = [&](int i) {
    tbb::parallel_for(std::size_t(0), patches.size(),
                      [&](std::size_t r) { patches[r].add(columns.col((7 * r + i) % columns.cols()).cast<double>()); });
  };
  for (int i = 0; i < 14; ++i) image(i);
  const auto start = Clock::now();
  for (int i = 14; i < 24; ++i) image(i);
  return 10 * 1e3 * seconds_since(start) / 10;
}

}  // namespace

void measure_speed(GoalReport& report) {
  const Eigen::MatrixXf columns = test_patch_columns(TestPatch::kTypical);
  double start = thread_seconds();
  batch_pca(columns, kDisplayed);
  const double gram_ms = 1e3 * (thread_seconds() - start);
  start = thread_seconds();
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(columns.cast<double>(), Eigen::ComputeThinU | Eigen::ComputeThinV);
  const double svd_ms = 1e3 * (thread_seconds() - start);

  const double peak = peak_multiply_adds_per_us();
  const double us_12 = us_per_column<float>(columns, 12), us_24 = us_per_column<float>(columns, 24);
  report.add(at_most(5, 2.5, "patch update, internal 12, in cache, 1 thread", us_12, "us",
                     {{"row_products_at_peak_us", row_products_us(columns.rows(), 12, peak)},
                      {"brand_cap_12_us", brand_us_per_column(columns, 12)},
                      {"batch_svd_of_300_ms", svd_ms},
                      {"batch_gram_of_300_ms", gram_ms}}));
  report.add(at_most(10, 5.5, "patch update, internal 24, in cache, 1 thread", us_24, "us",
                     {{"row_products_at_peak_us", row_products_us(columns.rows(), 24, peak)},
                      {"brand_cap_24_us", brand_us_per_column(columns, 24)}}));

  const std::vector<double> ms = ms_per_image(columns, 12, 180, true);
  const double median = quantile(ms, 0.5);
  report.add(at_most(60, 33, "3,500 patches all visible, per image, internal 12", median, "ms",
                     {{"one_thread_ms", quantile(ms_per_image(columns, 12, 24, false), 0.5)},
                      {"brand_cap_12_ms", brand_ms_per_image(columns)},
                      {"batch_gram_ms", kPatches * gram_ms}}));
  const std::vector<double> ms_24 = ms_per_image(columns, 24, 120, true);
  report.add(at_most(1.5, {}, "  its p99 over its median", quantile(ms, 0.99) / median, "ratio",
                     {{"p99_ms", quantile(ms, 0.99)},
                      {"internal_24_ms", quantile(ms_24, 0.5)},
                      {"internal_24_p99_over_median", quantile(ms_24, 0.99) / quantile(ms_24, 0.5)}}));

  const double double_12 = us_per_column<double>(columns, 12), double_24 = us_per_column<double>(columns, 24);
  report.add({.name = "double over float, time of an update, internal 24",
              .value = double_24 / us_24,
              .unit = "ratio",
              .compared_with = {{"double_24_us", double_24}, {"internal_12_ratio", double_12 / us_12}}});
}

}  // namespace sheen
