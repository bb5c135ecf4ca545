// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/known_grams.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <utility>
#include <vector>

namespace sheen {
namespace {

using Eigen::MatrixXd;
using row_panels::Columns;

constexpr int kNone = -1;

/// Neighbouring rows that are hidden in the same columns.
struct Run {
  int first, count;
  int next;  ///< of the same pattern
};

/// All rows that are hidden in the same columns.
struct Group {
  std::uint64_t hidden;
  int rows, runs;  ///< their number; the first of them
};

struct Patterns {
  std::vector<Run> runs;
  std::vector<Group> groups;
};

/// Patterns that were met, by a hash of them; open addressing.
class PatternIndex {
 public:
  explicit PatternIndex(std::size_t most)
      : shift_(64 - std::bit_width(2 * most)), slots_(std::size_t{1} << (64 - shift_), kNone) {}

  /// Where the pattern's group is noted, or kNone stands.
  int& slot(std::uint64_t pattern, const std::vector<Group>& groups) {
    constexpr std::uint64_t kGoldenRatio = 0x9e3779b97f4a7c15;  // times 2^64
    std::size_t at = pattern * kGoldenRatio >> shift_;
    while (slots_[at] != kNone && groups[slots_[at]].hidden != pattern) at = (at + 1) % slots_.size();
    return slots_[at];
  }

 private:
  int shift_;
  std::vector<int> slots_;
};

/// A sample's channels, and mostly its neighbours, are hidden together; what is hidden lies apart.
Patterns group_rows(std::span<const std::uint64_t> hidden) {
  Patterns patterns;
  const auto rows = static_cast<int>(hidden.size());
  for (int row = 0; row < rows; ++row)
    if (row == 0 || hidden[row] != hidden[row - 1]) patterns.runs.push_back({row, 0, kNone});
  PatternIndex index(patterns.runs.size());
  for (auto run = static_cast<int>(patterns.runs.size()) - 1, end = rows; run >= 0; --run) {
    Run& at = patterns.runs[run];
    at.count = end - at.first;
    end = at.first;
    int& group = index.slot(hidden[at.first], patterns.groups);
    if (group == kNone) {
      group = static_cast<int>(patterns.groups.size());
      patterns.groups.push_back({hidden[at.first], 0, kNone});
    }
    at.next = std::exchange(patterns.groups[group].runs, run);
    patterns.groups[group].rows += at.count;
  }
  return patterns;
}

/// The upper triangle of a symmetric matrix in vectors of `kLanes` rows each: of rows 0.. all columns, of rows kLanes..
/// the columns from there on, and so on. What lies below the diagonal in a vector means nothing.
template <typename Scalar>
struct Triangle {
  static constexpr int kLanes = row_panels::VectorOf<Scalar>::kLanes;
  int size;

  int vectors() const {
    int count = 0;
    for (int row = 0; row < size; row += kLanes) count += size - row;
    return count;
  }
  /// Calls visit(first row, column) for the vectors in their order.
  template <typename Visit>
  void visit(Visit visit) const {
    for (int row = 0; row < size; row += kLanes)
      for (int column = row; column < size; ++column) visit(row, column);
  }
};

/// Gram matrices of some rows of the basis.
template <typename Scalar>
class RowGrams {
 public:
  explicit RowGrams(const Columns<const Scalar>& basis)
      : basis_(basis), stride_(row_panels::padded(basis.count)), picked_(kPicked * stride_ + kTile, Scalar(0)) {}

  /// Of the rows of a group, as a `Triangle`.
  void gram(const Patterns& patterns, const Group& group, Scalar* triangle) {
    std::fill_n(triangle, Triangle<Scalar>{basis_.count}.vectors() * kLanes, Scalar(0));
    int picked = 0;
    for (int run = group.runs; run != kNone; run = patterns.runs[run].next) {
      auto [row, left, next] = patterns.runs[run];
      while (left > 0) {
        const int count = std::min(left, kPicked - picked);
        pick(row, count, picked);
        picked += count;
        row += count;
        left -= count;
        if (picked == kPicked) add_products(std::exchange(picked, 0), triangle);
      }
    }
    if (picked > 0) add_products(picked, triangle);
  }

 private:
  static constexpr int kLanes = Triangle<Scalar>::kLanes;
  static constexpr int kTile = 8;      // columns
  static constexpr int kPicked = 256;  // rows whose products are summed up before others are added
  static_assert(row_panels::kPadding % kLanes == 0 && row_panels::kPadding % kTile == 0);

  void pick(int row, int count, int to) {
    for (int i = 0; i < count; ++i) {  // mostly few
      const Scalar* from = basis_.data + row + i;
      Scalar* const picked = &picked_[(to + i) * stride_];
      for (int k = 0; k < basis_.count; ++k) picked[k] = from[k * basis_.stride];
    }
  }

  void add_products(int rows, Scalar* triangle) const {
    for (int i = 0; i < basis_.count; i += kLanes) {
      for (int j = i; j < basis_.count; j += kTile) add_tile(rows, i, j, triangle + (j - i) * kLanes);
      triangle += (basis_.count - i) * kLanes;
    }
  }

  void add_tile(int rows, int i, int j, Scalar* to) const {
    row_panels::Vector<Scalar> sum[kTile] = {};
    for (const Scalar* row = picked_.data(); row < picked_.data() + rows * stride_; row += stride_) {
      const auto left = row_panels::load(row + i);
      for (int t = 0; t < kTile; ++t) sum[t] += left * row[j + t];
    }
    for (int t = 0; t < kTile && j + t < basis_.count; ++t, to += kLanes)
      row_panels::store(to, row_panels::load(to) + sum[t]);
  }

  Columns<const Scalar> basis_;
  std::ptrdiff_t stride_;
  std::vector<Scalar> picked_;  ///< rows, one behind the other, padded to whole vectors, and a tile
};

/// Sums of chosen Gram matrices, another choice for every column ("four Russians"): the sums of all choices among four
/// matrices are made once, and a column adds one of them in place of up to four matrices.
template <typename Scalar>
class ChosenSums {
 public:
  ChosenSums(int vectors, int columns)
      : vectors_(vectors),
        columns_(columns),
        matrices_(kAtOnce * vectors * kLanes),
        sums_(MatrixXd::Zero(vectors * kLanes, columns)) {}

  /// Where the next matrix is to be written. `columns`: bit j is set when it is part of column j's sum.
  Scalar* next(std::uint64_t columns) {
    if (waiting_ == kAtOnce) flush();
    chosen_by_[waiting_] = columns;
    return &matrices_[waiting_++ * vectors_ * kLanes];
  }

  /// One sum per column, of as many numbers as a matrix has.
  const MatrixXd& sums() {
    flush();
    return sums_;
  }

 private:
  using Vector = row_panels::Vector<Scalar>;
  static constexpr int kLanes = row_panels::VectorOf<Scalar>::kLanes;
  static constexpr int kFew = 4, kChoices = 1 << kFew;
  static constexpr int kAtOnce = 64;  // matrices; their choices of one vector fill half of a small first-level cache

  void flush() {
    const int quads = (waiting_ + kFew - 1) / kFew;
    for (; waiting_ < quads * kFew; ++waiting_) {
      chosen_by_[waiting_] = 0;
      std::fill_n(&matrices_[waiting_ * vectors_ * kLanes], vectors_ * kLanes, Scalar(0));
    }
    for (int q = 0; q < quads; ++q)
      for (int j = 0; j < columns_; ++j) {
        unsigned choice = 0;
        for (int k = 0; k < kFew; ++k) choice |= (chosen_by_[kFew * q + k] >> j & 1) << k;
        choice_[q][j] = static_cast<std::uint8_t>(choice);
      }
    for (int v = 0; v < vectors_; ++v) add_vector(v, quads);
    waiting_ = 0;
  }

  void add_vector(int v, int quads) {
    Vector sum_of[kAtOnce / kFew][kChoices];
    for (int q = 0; q < quads; ++q) {
      sum_of[q][0] = Vector{};
      for (int k = 0; k < kFew; ++k) {
        const Vector matrix = row_panels::load(&matrices_[((kFew * q + k) * vectors_ + v) * kLanes]);
        for (int others = 0; others < 1 << k; ++others) sum_of[q][others | 1 << k] = sum_of[q][others] + matrix;
      }
    }
    for (int j = 0; j < columns_; ++j) {
      Vector sum{};
      for (int q = 0; q < quads; ++q) sum += sum_of[q][choice_[q][j]];
      double* to = &sums_(v * kLanes, j);
      for (int lane = 0; lane < kLanes; ++lane) to[lane] += sum[lane];
    }
  }

  int vectors_, columns_;
  int waiting_ = 0;
  std::array<std::uint64_t, kAtOnce> chosen_by_;
  std::array<std::array<std::uint8_t, kPatternColumns>, kAtOnce / kFew> choice_;
  std::vector<Scalar> matrices_;
  MatrixXd sums_;
};

}  // namespace

template <typename Scalar>
MatrixXd known_grams(const Columns<const Scalar>& basis, std::span<const std::uint64_t> hidden, int columns) {
  const Patterns patterns = group_rows(hidden);
  std::vector<std::size_t> hidden_rows(columns, 0);
  for (const Group& group : patterns.groups)
    for (std::uint64_t bits = group.hidden; bits != 0; bits &= bits - 1)
      hidden_rows[std::countr_zero(bits)] += static_cast<std::size_t>(group.rows);
  std::uint64_t mostly_hidden = 0;
  for (int j = 0; j < columns; ++j)
    if (2 * hidden_rows[j] > hidden.size()) mostly_hidden |= std::uint64_t{1} << j;

  const Triangle<Scalar> triangle{basis.count};
  const std::uint64_t all = columns == kPatternColumns ? ~std::uint64_t{0} : (std::uint64_t{1} << columns) - 1;
  RowGrams<Scalar> rows(basis);
  ChosenSums<Scalar> chosen(triangle.vectors(), columns);
  for (const Group& group : patterns.groups)
    if (const std::uint64_t counted = (group.hidden ^ mostly_hidden) & all; counted != 0)
      rows.gram(patterns, group, chosen.next(counted));

  const Eigen::Index rank = basis.count;
  const MatrixXd& sums = chosen.sums();
  MatrixXd known(rank * rank, columns);
  for (int j = 0; j < columns; ++j) {
    Eigen::Map<MatrixXd> gram(known.col(j).data(), rank, rank);
    const double identity = mostly_hidden >> j & 1 ? 0 : 1, sign = mostly_hidden >> j & 1 ? 1 : -1;
    const double* sum = sums.col(j).data();
    triangle.visit([&](int row, int column) {
      for (int i = row; i <= std::min(column, row + Triangle<Scalar>::kLanes - 1); ++i)
        gram(i, column) = gram(column, i) = sign * sum[i - row];
      sum += Triangle<Scalar>::kLanes;
    });
    gram.diagonal().array() += identity;
  }
  return known;
}

template MatrixXd known_grams<float>(const Columns<const float>&, std::span<const std::uint64_t>, int);
template MatrixXd known_grams<double>(const Columns<const double>&, std::span<const std::uint64_t>, int);

}  // namespace sheen
