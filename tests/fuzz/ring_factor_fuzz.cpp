// SPDX-License-Identifier: Apache-2.0
// Whatever is added, imputed, removed and merged, in whatever order: the invariants of the factorization hold, and its
// energies are those of the columns.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

#include "reconstructor/numerics/ring_factor.h"
#include "tests/support/ring_factor_checks.h"

namespace {

using namespace sheen;

/// Cuts pieces off the front of the input; zeros when it is used up.
struct Input {
  std::span<const std::uint8_t> rest;
  std::uint8_t byte() {
    if (rest.empty()) return 0;
    const std::uint8_t value = rest[0];
    rest = rest.subspan(1);
    return value;
  }
  /// Any float, NaN and infinity among them.
  float bits() {
    std::uint32_t word = 0;
    for (int i = 0; i < 4; ++i) word = word << 8 | byte();
    float value;
    std::memcpy(&value, &word, sizeof value);
    return value;
  }
};

[[noreturn]] void fail(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}

/// Columns from few bytes: constant, ramp, one spot, small integers, arbitrary bits, or like the one before.
Eigen::VectorXf next_column(Input& in, const Eigen::VectorXf& before) {
  const int rows = static_cast<int>(before.size());
  const std::uint8_t kind = in.byte();
  Eigen::VectorXf column = Eigen::VectorXf::Zero(rows);
  switch (kind % 8) {
    case 0:
      break;
    case 1:
      column.setConstant(static_cast<float>(in.byte()) / 64);
      break;
    case 2:
      column = Eigen::VectorXf::LinSpaced(rows, static_cast<float>(in.byte()), static_cast<float>(in.byte()));
      break;
    case 3:
      column[in.byte() % rows] = static_cast<float>(in.byte());
      break;
    case 4:
      for (float& value : column) value = static_cast<float>(in.byte()) - 128;
      break;
    case 5:
      column = before;
      column[in.byte() % rows] = in.bits();
      break;
    case 6:
      column = before;
      column[in.byte() % rows] *= 1 + 1e-6f * static_cast<float>(in.byte());
      break;
    default:
      column = -before;
  }
  if (kind & 0x80) column *= std::ldexp(1.0f, in.byte() % 200 - 100);
  // What a camera cannot mean: a norm that single precision does not hold.
  for (float& value : column)
    if (std::isfinite(value) && std::abs(value) > 1e36f) value = 1e36f;
  return column;
}

struct Column {
  double weight = 0;
  double energy = 0;
};

double energy_of(const std::vector<Column>& columns) {
  double energy = 0;
  for (const Column& column : columns) energy += column.weight * column.energy;
  return energy;
}

template <typename Scalar>
void run(Input in) {
  int rows = 1 + in.byte() % 40;
  RingFactorOptions options{.max_rank = 1 + in.byte() % 10, .block = 1 + in.byte() % 14};
  const std::uint8_t choice = in.byte();
  options.tolerance = choice % 4 == 0 ? 0 : std::pow(10.0, -(choice % 4));
  if (choice & 32) rows *= 8;  // more than one panel of rows
  if (choice & 16) options.internal_rank = options.max_rank + choice / 64;
  BasicRingFactor<Scalar> factor(rows, options, in.byte());

  std::vector<Column> columns;  // a view; meaningless once `exact` is false
  double largest = 0;           // sum of energies ever held: the size of what rounding can leave behind
  bool exact = true;            // nothing missing, nothing merged, no digits lost: the energy is known
  Eigen::VectorXf column = Eigen::VectorXf::Ones(rows);
  while (!in.rest.empty()) {
    const std::uint8_t act = in.byte();
    switch (act % 8) {
      default: {
        column = next_column(in, column);
        const double weight = act & 64 ? std::ldexp(1.0, in.byte() % 40 - 20) : 1;
        std::vector<std::uint8_t> known;
        if (act & 32) {
          known.resize(static_cast<std::size_t>(rows), 0);
          const int first = in.byte() % rows, shown = in.byte() % (rows + 1);
          for (int i = 0; i < shown; ++i) known[(first + i) % rows] = 1;
        }
        constexpr float kFewDigits = 1e-39f;  // denormals: coefficients of that size have no more of them either
        const float peak = column.cwiseAbs().maxCoeff();
        exact = exact && known.empty() && column.allFinite() && (peak == 0 || peak > kFewDigits);
        columns.push_back({weight, column.cast<double>().squaredNorm()});
        largest += std::isfinite(columns.back().energy) ? weight * columns.back().energy : 0;
        factor.add(column.cast<Scalar>(), known, weight);
        if (!column.allFinite()) column.setOnes();
        break;
      }
      case 5:
        if (factor.views() > 0) {
          const int view = in.byte() % factor.views();
          factor.remove(view);
          columns.erase(columns.begin() + view);
        }
        break;
      case 6:
        if (factor.folded_views() > 1) {
          const int kept = in.byte() % factor.folded_views(), removed = in.byte() % factor.folded_views();
          if (kept == removed) break;
          factor.merge_views(kept, removed);
          columns[kept] = {columns[kept].weight + columns[removed].weight, 0};
          columns.erase(columns.begin() + removed);
          exact = false;
        }
        break;
      case 7:
        factor.fold();
    }
    if (factor.views() != static_cast<int>(columns.size())) fail("views were lost");
    if (const std::string broken = broken_invariants(factor); !broken.empty()) fail(broken);
    if (columns.size() > 96) return;
  }
  const BasicRingFactor<Scalar> settled = factor.settled();
  if (const std::string broken = broken_invariants(settled); !broken.empty()) fail("settled: " + broken);
  if (exact && std::abs(settled.energy() - energy_of(columns)) > 1e-4 * largest) fail("the energy is not the columns'");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input in{{data, size}};
  if (in.byte() % 4 == 0)
    run<double>(in);
  else
    run<float>(in);
  return 0;
}
