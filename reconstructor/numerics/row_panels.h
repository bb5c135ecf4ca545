// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>

/// Products of tall, skinny matrices (thousands of rows, tens of columns), on columns whose length is padded to a
/// multiple of `kPadding` with zeros. Written for registers of any width; the compiler's vector extension picks the
/// instructions that the build allows.
namespace sheen::row_panels {

inline constexpr int kPadding = 16;  ///< rows
inline constexpr Eigen::Index padded(Eigen::Index rows) {
  return (rows + kPadding - 1) / kPadding * kPadding;
}

#if defined(__AVX512F__)
inline constexpr int kVectorBytes = 64;
inline constexpr int kDotA = 4, kDotB = 4;               // register tile of inner products
inline constexpr int kCombineRows = 4, kCombineOut = 4;  // and of combinations: vectors x columns
#elif defined(__AVX__)
inline constexpr int kVectorBytes = 32;
inline constexpr int kDotA = 4, kDotB = 3;
inline constexpr int kCombineRows = 2, kCombineOut = 6;
#else
inline constexpr int kVectorBytes = 16;
inline constexpr int kDotA = 3, kDotB = 3;
inline constexpr int kCombineRows = 2, kCombineOut = 4;
#endif

template <typename T>
struct VectorOf {
  typedef T type __attribute__((vector_size(kVectorBytes)));
  typedef T in_memory __attribute__((vector_size(kVectorBytes), may_alias, aligned(sizeof(T))));
  static constexpr int kLanes = kVectorBytes / static_cast<int>(sizeof(T));
};
template <typename T>
using Vector = typename VectorOf<T>::type;

template <typename T>
inline Vector<T> load(const T* from) {
  return *reinterpret_cast<const typename VectorOf<T>::in_memory*>(from);
}
template <typename T>
inline void store(T* to, const Vector<T>& v) {
  *reinterpret_cast<typename VectorOf<T>::in_memory*>(to) = v;
}
/// The same, for a value that is used several times: left alone, gcc reads it from memory for every use, and the loads
/// take longer than the arithmetic.
template <typename T>
inline Vector<T> load_once(const T* from) {
  Vector<T> v = load(from);
#if defined(__x86_64__)
  asm("" : "+v"(v));
#endif
  return v;
}

/// Columns side by side, `stride` apart.
template <typename T>
struct Columns {
  T* data;
  Eigen::Index stride;
  int count;
  T* column(int j) const { return data + j * stride; }
  Columns from(int j) const { return {column(j), stride, count - j}; }
  Columns first(int columns) const { return {data, stride, columns}; }
  operator Columns<const T>() const requires(!std::is_const_v<T>) { return {data, stride, count}; }
};

template <typename Derived>
Columns<const typename Derived::Scalar> columns(const Eigen::PlainObjectBase<Derived>& m, int count) {
  return {m.data(), m.rows(), count};
}

/// Half as many lanes in double, each the sum of two.
inline Vector<double> widened(const Vector<double>& v) {
  return v;
}
inline Vector<double> widened(const Vector<float>& v) {
  constexpr int half = VectorOf<double>::kLanes;
  typedef float Half __attribute__((vector_size(half * sizeof(float))));
  return [&]<int... Lane>(std::integer_sequence<int, Lane...>) {
    const Half low = __builtin_shufflevector(v, v, Lane...), high = __builtin_shufflevector(v, v, (half + Lane)...);
    return __builtin_convertvector(low, Vector<double>) + __builtin_convertvector(high, Vector<double>);
  }
  (std::make_integer_sequence<int, half>());
}

/// Sums of neighbouring lanes, those of x before those of y.
inline Vector<double> pairwise_sums(const Vector<double>& x, const Vector<double>& y) {
  return [&]<int... Lane>(std::integer_sequence<int, Lane...>) {
    return __builtin_shufflevector(x, y, (2 * Lane)...) + __builtin_shufflevector(x, y, (2 * Lane + 1)...);
  }
  (std::make_integer_sequence<int, VectorOf<double>::kLanes>());
}

/// sums[k] += all lanes of v[k], in double.
template <typename T, int Count>
inline void add_lanes(const Vector<T> (&v)[Count], double* sums) {
  constexpr int lanes = VectorOf<double>::kLanes;
  for (int first = 0; first < Count; first += lanes) {
    Vector<double> wide[lanes] = {};
    for (int k = 0; k < lanes && first + k < Count; ++k) wide[k] = widened(v[first + k]);
    for (int left = lanes / 2; left > 0; left /= 2)
      for (int k = 0; k < left; ++k) wide[k] = pairwise_sums(wide[2 * k], wide[2 * k + 1]);
    for (int k = 0; k < lanes && first + k < Count; ++k) sums[first + k] += wide[0][k];
  }
}

/// A lane sums few products at a time, in the columns' own precision, and then those sums: where all are rounded the
/// same way, as those of a constant column, the error grows with the length of a sum. Long sums are added up in double.
inline constexpr int kShortSum = 16, kLongSum = 256;  // products

/// `Above`: of a square of A^T A, only what is above the diagonal; the rest of `out` is left as it is.
template <typename T, int A, int B, bool Above = false>
void inner_tile(const Columns<const T>& a, const Columns<const T>& b, Eigen::Index rows, double* out,
                Eigen::Index out_stride) {
  constexpr int lanes = VectorOf<T>::kLanes;
  double sums[A * B] = {};
  for (Eigen::Index r = 0; r < rows;) {
    const Eigen::Index long_end = std::min<Eigen::Index>(rows, r + kLongSum * lanes);
    Vector<T> long_sums[A * B] = {};
    while (r < long_end) {
      const Eigen::Index short_end = std::min<Eigen::Index>(long_end, r + kShortSum * lanes);
      Vector<T> acc[A * B] = {};
      for (; r < short_end; r += lanes) {
        Vector<T> vb[B];
        for (int j = 0; j < B; ++j) vb[j] = load_once(b.column(j) + r);
        for (int i = 0; i < A; ++i) {
          const Vector<T> va = load_once(a.column(i) + r);
          for (int j = Above ? i + 1 : 0; j < B; ++j) acc[i + j * A] += va * vb[j];
        }
      }
      for (int k = 0; k < A * B; ++k) long_sums[k] += acc[k];
    }
    add_lanes<T>(long_sums, sums);
  }
  for (int j = 0; j < B; ++j)
    for (int i = 0; i < (Above ? j : A); ++i) out[i + j * out_stride] = sums[i + j * A];
}

template <typename T, int A, int B>
void inner_remainder(const Columns<const T>& a, const Columns<const T>& b, Eigen::Index rows, double* out,
                     Eigen::Index out_stride) {
  if constexpr (A > 1) {
    if (a.count < A) return inner_remainder<T, A - 1, B>(a, b, rows, out, out_stride);
  }
  if constexpr (B > 1) {
    if (b.count < B) return inner_remainder<T, A, B - 1>(a, b, rows, out, out_stride);
  }
  inner_tile<T, A, B>(a, b, rows, out, out_stride);
}

/// A^T B, in double.
template <typename T>
Eigen::MatrixXd inner_products(const Columns<const T>& a, const Columns<const T>& b, Eigen::Index rows) {
  Eigen::MatrixXd out(a.count, b.count);
  for (int i = 0; i < a.count; i += kDotA)
    for (int j = 0; j < b.count; j += kDotB)
      inner_remainder<T, kDotA, kDotB>(a.from(i), b.from(j), rows, &out(i, j), out.rows());
  return out;
}

/// ||column||^2 of each, to a few units of rounding: a bright row and many dim ones, whose squares would be rounded
/// alike beside its own, are a highlight.
template <typename T>
Eigen::VectorXd squared_norms(const Columns<const T>& columns, Eigen::Index rows) {
  constexpr int lanes = VectorOf<T>::kLanes, at_once = 4, in_short = 4;  // products, in the columns' own precision
  Eigen::VectorXd out(columns.count);
  for (int j = 0; j < columns.count; j += at_once) {
    const int count = std::min(at_once, columns.count - j);
    const T* column[at_once];
    for (int k = 0; k < at_once; ++k) column[k] = columns.column(j + std::min(k, count - 1));
    Vector<double> sums[at_once] = {};
    for (Eigen::Index first = 0; first < rows; first += in_short * lanes) {
      const Eigen::Index last = std::min<Eigen::Index>(rows, first + in_short * lanes);
      Vector<T> acc[at_once] = {};
      for (Eigen::Index r = first; r < last; r += lanes)
        for (int k = 0; k < at_once; ++k) {
          const Vector<T> v = load_once(column[k] + r);
          acc[k] += v * v;
        }
      for (int k = 0; k < at_once; ++k) sums[k] += widened(acc[k]);
    }
    double all[at_once] = {};
    add_lanes<double>(sums, all);
    std::copy_n(all, count, out.data() + j);
  }
  return out;
}

/// A^T A above its diagonal, of the first A columns or of all if they are fewer.
template <typename T, int A>
void products_above_diagonal(const Columns<const T>& a, Eigen::Index rows, double* out, Eigen::Index out_stride) {
  if constexpr (A > 1) {
    if (a.count < A) return products_above_diagonal<T, A - 1>(a, rows, out, out_stride);
    inner_tile<T, A, A, true>(a, a, rows, out, out_stride);
  }
}

/// A^T A, in double. `norms2`: the squared norms of its columns.
template <typename T>
Eigen::MatrixXd gram(const Columns<const T>& a, Eigen::Index rows, const Eigen::VectorXd& norms2) {
  Eigen::MatrixXd out(a.count, a.count);
  for (int i = 0; i < a.count; i += kDotB) {
    products_above_diagonal<T, kDotB>(a.from(i), rows, &out(i, i), out.rows());
    for (int j = i + kDotB; j < a.count; j += kDotB)
      inner_remainder<T, kDotB, kDotB>(a.from(i), a.from(j), rows, &out(i, j), out.rows());
  }
  out.diagonal() = norms2;
  for (int j = 0; j < a.count; ++j)
    for (int i = j + 1; i < a.count; ++i) out(i, j) = out(j, i);
  return out;
}
template <typename T>
Eigen::MatrixXd gram(const Columns<const T>& a, Eigen::Index rows) {
  return gram(a, rows, squared_norms(a, rows));
}

/// R vectors of rows of J columns. (Unrolled early, or gcc 12 keeps the sums in memory.)
template <typename T, int R, int J>
void combine_tile(const Columns<const T> a, const Columns<const T> p, const T* m, Eigen::Index m_stride,
                  const Columns<T> out, bool add) {
  constexpr int lanes = VectorOf<T>::kLanes;
  Vector<T> acc[J][R] = {};
  if (add)
#pragma GCC unroll 16
    for (int j = 0; j < J; ++j)
#pragma GCC unroll 16
      for (int v = 0; v < R; ++v) acc[j][v] = load(out.column(j) + v * lanes);
  for (const Columns<const T>* from : {&a, &p})
    for (int i = 0; i < from->count; ++i, ++m) {
      Vector<T> va[R];
#pragma GCC unroll 16
      for (int v = 0; v < R; ++v) va[v] = load_once(from->column(i) + v * lanes);
#pragma GCC unroll 16
      for (int j = 0; j < J; ++j)
#pragma GCC unroll 16
        for (int v = 0; v < R; ++v) acc[j][v] += va[v] * m[j * m_stride];
    }
#pragma GCC unroll 16
  for (int j = 0; j < J; ++j)
#pragma GCC unroll 16
    for (int v = 0; v < R; ++v) store(out.column(j) + v * lanes, acc[j][v]);
}

template <typename T, int R, int J>
void combine_remainder(const Columns<const T>& a, const Columns<const T>& p, const T* m, Eigen::Index m_stride,
                       const Columns<T>& out, bool add) {
  if constexpr (J > 1) {
    if (out.count < J) return combine_remainder<T, R, J - 1>(a, p, m, m_stride, out, add);
  }
  combine_tile<T, R, J>(a, p, m, m_stride, out, add);
}

/// R vectors of rows of all columns. `scratch`: as many, unless it adds.
template <typename T, int R>
void combine_panel(const Columns<const T>& a, const Columns<const T>& p,
                   const Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>& m, const Columns<T>& out, bool add,
                   T* scratch) {
  constexpr int lanes = VectorOf<T>::kLanes;
  const Columns<T> to = add ? out : Columns<T>{scratch, R * lanes, out.count};
  for (int j = 0; j < out.count; j += kCombineOut)
    combine_remainder<T, R, kCombineOut>(a, p, m.data() + j * m.rows(), m.rows(),
                                         {to.column(j), to.stride, out.count - j}, add);
  if (add) return;
  for (int j = 0; j < out.count; ++j)
    for (int v = 0; v < R; ++v) store(out.column(j) + v * lanes, load(to.column(j) + v * lanes));
}

/// Whole panels of R vectors of rows from `row` on, then what is left in smaller ones.
template <typename T, int R>
void combine_rows(const Columns<const T>& a, const Columns<const T>& p,
                  const Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>& m, Eigen::Index row, Eigen::Index rows,
                  const Columns<T>& out, bool add, T* scratch) {
  constexpr int panel = R * VectorOf<T>::kLanes;
  const auto from = [](auto columns, Eigen::Index first) {
    if (columns.count > 0) columns.data += first;  // none may be nowhere
    return columns;
  };
  for (; row + panel <= rows; row += panel)
    combine_panel<T, R>(from(a, row), from(p, row), m, from(out, row), add, scratch);
  if constexpr (R > 1) combine_rows<T, R / 2>(a, p, m, row, rows, out, add, scratch);
}

/// out = [A P] M, where `out` may be the same memory as A or P; or out += [A P] M, where it may not.
template <typename T>
void combine(const Columns<const T>& a, const Columns<const T>& p,
             const Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>& m, Eigen::Index rows, const Columns<T>& out,
             bool add = false) {
  Eigen::Matrix<T, Eigen::Dynamic, 1> scratch(add ? 0 : kCombineRows * VectorOf<T>::kLanes * out.count);
  combine_rows<T, kCombineRows>(a, p, m, 0, rows, out, add, scratch.data());
}

}  // namespace sheen::row_panels
