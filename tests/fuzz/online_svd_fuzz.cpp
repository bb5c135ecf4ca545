// SPDX-License-Identifier: Apache-2.0
// Whatever is added, imputed, removed, merged, taken back out of what was merged, and limited, in whatever order: the
// invariants of the factorization hold, each view has the weight of its columns, and its energies are theirs.
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "reconstructor/numerics/online_svd.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/support/online_svd_checks.h"

namespace {

using namespace sheen;
using fuzz::demand;
using fuzz::fail;
using fuzz::Input;

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
      column[in.byte() % rows] = in.bits<float>();
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

/// As it was added.
struct Column {
  Eigen::VectorXf values;
  std::vector<std::uint8_t> known;
  double weight = 0;
};

using View = std::vector<Column>;  ///< more than one where views were merged

double weight_of(const View& view) {
  double weight = 0;
  for (const Column& column : view) weight += column.weight;
  return weight;
}

double energy_of(const std::vector<View>& views) {
  double energy = 0;
  for (const View& view : views)
    for (const Column& column : view) energy += column.weight * column.values.cast<double>().squaredNorm();
  return energy;
}

template <typename Scalar>
void take_one_out(BasicOnlineSvd<Scalar>& factor, std::vector<View>& views, Input& in) {
  if (factor.folded_views() == 0) return;
  const int at = in.byte() % factor.folded_views();
  View& view = views[at];
  const auto column = view.begin() + in.byte() % static_cast<std::ptrdiff_t>(view.size());
  const double weight = weight_of(view);
  factor.take_from(at, column->values.cast<Scalar>(), column->known, column->weight);
  view.erase(column);
  if (factor.views() == static_cast<int>(views.size())) return;
  demand(weight_of(view) <= 1e-6 * weight, "a view went though columns of it were left");
  views.erase(views.begin() + at);
}

template <typename Scalar>
void expect_weights(const BasicOnlineSvd<Scalar>& factor, const std::vector<View>& views) {
  demand(factor.views() == static_cast<int>(views.size()), "views were lost");
  for (int v = 0; v < factor.views(); ++v)
    demand(std::abs(factor.weight_of(v) - weight_of(views[v])) <= 1e-6 * weight_of(views[v]),
           "a view has not the weight of its columns");
}

template <typename Scalar>
void run(Input in) {
  int rows = 1 + in.byte() % 40;
  OnlineSvdOptions options{.max_rank = 1 + in.byte() % 10, .block = 1 + in.byte() % 14};
  const std::uint8_t choice = in.byte();
  options.tolerance = choice % 4 == 0 ? 0 : std::pow(10.0, -(choice % 4));
  if (choice & 32) rows *= 8;  // more than one panel of rows
  if (choice & 16) options.internal_rank = options.max_rank + choice / 64;
  if (choice & 8) options.sensor_variance = 2e-5;  // and so in fixed point between folds
  BasicOnlineSvd<Scalar> factor(rows, options, in.byte());

  std::vector<View> views;
  std::int64_t columns = 0;    ///< ever added
  double largest = 0;          // sum of energies ever held: the size of what rounding can leave behind
  bool exact = !(choice & 8);  // nothing missing, nothing merged, no digits lost: the energy is known
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
        const double energy = weight * column.cast<double>().squaredNorm();
        largest += std::isfinite(energy) ? energy : 0;
        views.push_back({{column, known, weight}});
        factor.add(column.cast<Scalar>(), known, weight);
        ++columns;
        if (!column.allFinite()) column.setOnes();
        break;
      }
      case 5:
        if (act / 64 == 2) {
          take_one_out(factor, views, in);
        } else if (factor.views() > 0) {
          const int view = in.byte() % factor.views();
          factor.remove(view);
          views.erase(views.begin() + view);
        }
        break;
      case 6:
        if (factor.folded_views() > 1) {
          const int kept = in.byte() % factor.folded_views(), removed = in.byte() % factor.folded_views();
          if (kept == removed) break;
          factor.merge_views(kept, removed);
          views[kept].insert(views[kept].end(), views[removed].begin(), views[removed].end());
          views.erase(views.begin() + removed);
          exact = false;
        }
        break;
      case 7:
        if (act / 64 == 2) {
          const int displayed = 1 + in.byte() % 8;
          factor.limit(displayed, displayed + in.byte() % 8, 1 + in.byte() % 8);
        } else {
          factor.fold();
        }
    }
    expect_weights(factor, views);
    if (const std::string broken = broken_invariants(factor, columns); !broken.empty()) fail(broken);
    if (views.size() > 96) return;
  }
  const BasicOnlineSvd<Scalar> settled = factor.settled();
  if (const std::string broken = broken_invariants(settled, columns); !broken.empty()) fail("settled: " + broken);
  if (exact && std::abs(settled.energy() - energy_of(views)) > 1e-4 * largest) fail("the energy is not the columns'");
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
