// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

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
inline constexpr int kDotA = 6, kDotB = 4;               // register tile of inner products
inline constexpr int kCombineRows = 4, kCombineOut = 6;  // and of combinations: vectors x columns
#elif defined(__AVX__)
inline constexpr int kVectorBytes = 32;
inline constexpr int kDotA = 4, kDotB = 3;
inline constexpr int kCombineRows = 2, kCombineOut = 6;
#else
inline constexpr int kVectorBytes = 16;
inline constexpr int kDotA = 4, kDotB = 3;
inline constexpr int kCombineRows = 2, kCombineOut = 6;
#endif

template <typename T>
struct VectorOf {
  typedef T type __attribute__((vector_size(kVectorBytes)));
  static constexpr int kLanes = kVectorBytes / static_cast<int>(sizeof(T));
};
template <typename T>
using Vector = typename VectorOf<T>::type;

template <typename T>
inline Vector<T> load(const T* from) {
  Vector<T> v;
  std::memcpy(&v, from, sizeof(v));
  return v;
}
template <typename T>
inline void store(T* to, const Vector<T>& v) {
  std::memcpy(to, &v, sizeof(v));
}

/// Columns side by side, `stride` apart.
template <typename T>
struct Columns {
  T* data;
  Eigen::Index stride;
  int count;
  T* column(int j) const { return data + j * stride; }
};

template <typename Derived>
Columns<const typename Derived::Scalar> columns(const Eigen::PlainObjectBase<Derived>& m, int count) {
  return {m.data(), m.rows(), count};
}

/// Sum of the lanes, in double.
template <typename T>
inline double lane_sum(const Vector<T>& v) {
  constexpr int lanes = VectorOf<T>::kLanes;
  typedef double Wide __attribute__((vector_size(lanes * sizeof(double))));
  const Wide wide = __builtin_convertvector(v, Wide);
  double lane[lanes];
  std::memcpy(lane, &wide, sizeof(lane));
  for (int half = lanes / 2; half > 0; half /= 2)
    for (int l = 0; l < half; ++l) lane[l] += lane[l + half];
  return lane[0];
}

/// A lane sums this many products in the columns' own precision; those sums are added up in double.
inline constexpr int kLaneProducts = 256;

template <typename T, int A, int B>
void inner_tile(const T* const* a, const T* const* b, Eigen::Index rows, double* out, Eigen::Index out_stride) {
  constexpr int lanes = VectorOf<T>::kLanes;
  for (int i = 0; i < A; ++i)
    for (int j = 0; j < B; ++j) out[i + j * out_stride] = 0;
  for (Eigen::Index first = 0; first < rows; first += kLaneProducts * lanes) {
    const Eigen::Index last = std::min<Eigen::Index>(rows, first + kLaneProducts * lanes);
    Vector<T> acc[A][B] = {};
    for (Eigen::Index r = first; r < last; r += lanes) {
      Vector<T> vb[B];
      for (int j = 0; j < B; ++j) vb[j] = load(b[j] + r);
      for (int i = 0; i < A; ++i) {
        const Vector<T> va = load(a[i] + r);
        for (int j = 0; j < B; ++j) acc[i][j] += va * vb[j];
      }
    }
    for (int i = 0; i < A; ++i)
      for (int j = 0; j < B; ++j) out[i + j * out_stride] += lane_sum<T>(acc[i][j]);
  }
}

template <typename T, int A, int B>
void inner_remainder(int a_count, int b_count, const T* const* a, const T* const* b, Eigen::Index rows, double* out,
                     Eigen::Index out_stride) {
  if constexpr (A > 1) {
    if (a_count < A) return inner_remainder<T, A - 1, B>(a_count, b_count, a, b, rows, out, out_stride);
  }
  if constexpr (B > 1) {
    if (b_count < B) return inner_remainder<T, A, B - 1>(a_count, b_count, a, b, rows, out, out_stride);
  }
  inner_tile<T, A, B>(a, b, rows, out, out_stride);
}

/// A^T B, in double. `symmetric`: A and B are the same columns.
template <typename T>
Eigen::MatrixXd inner_products(const Columns<const T>& a, const Columns<const T>& b, Eigen::Index rows,
                               bool symmetric = false) {
  Eigen::MatrixXd out(a.count, b.count);
  for (int i = 0; i < a.count; i += kDotA)
    for (int j = 0; j < b.count; j += kDotB) {
      if (symmetric && j + kDotB <= i) continue;
      const int na = std::min(kDotA, a.count - i), nb = std::min(kDotB, b.count - j);
      std::array<const T*, kDotA> pa;
      std::array<const T*, kDotB> pb;
      for (int k = 0; k < na; ++k) pa[k] = a.column(i + k);
      for (int k = 0; k < nb; ++k) pb[k] = b.column(j + k);
      inner_remainder<T, kDotA, kDotB>(na, nb, pa.data(), pb.data(), rows, &out(i, j), out.rows());
    }
  if (symmetric)
    for (int j = 0; j < b.count; ++j)
      for (int i = j + 1; i < a.count; ++i) out(i, j) = out(j, i);
  return out;
}

template <typename T>
double squared_norm(const T* column, Eigen::Index rows) {
  double out;
  inner_tile<T, 1, 1>(&column, &column, rows, &out, 1);
  return out;
}

template <typename T, int R, int J>
void combine_tile(const T* const* a, int count, Eigen::Index row, const T* m, const T* const* plus, T* out,
                  Eigen::Index out_stride) {
  constexpr int lanes = VectorOf<T>::kLanes;
  Vector<T> acc[J][R] = {};
  if (plus)
    for (int j = 0; j < J; ++j)
      for (int v = 0; v < R; ++v) acc[j][v] = load(plus[j] + row + v * lanes);
  for (int i = 0; i < count; ++i) {
    Vector<T> va[R];
    for (int v = 0; v < R; ++v) va[v] = load(a[i] + row + v * lanes);
    for (int j = 0; j < J; ++j)
      for (int v = 0; v < R; ++v) acc[j][v] += va[v] * m[i * kCombineOut + j];
  }
  for (int j = 0; j < J; ++j)
    for (int v = 0; v < R; ++v) store(out + j * out_stride + v * lanes, acc[j][v]);
}

template <typename T, int R, int J>
void combine_remainder(int j_count, const T* const* a, int count, Eigen::Index row, const T* m, const T* const* plus,
                       T* out, Eigen::Index out_stride) {
  if constexpr (J > 1) {
    if (j_count < J) return combine_remainder<T, R, J - 1>(j_count, a, count, row, m, plus, out, out_stride);
  }
  combine_tile<T, R, J>(a, count, row, m, plus, out, out_stride);
}

/// out = [A P] M, or out += [A P] M. `out` may be the same memory as A or P.
template <typename T>
void combine(const Columns<const T>& a, const Columns<const T>& p,
             const Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>& m, Eigen::Index rows, const Columns<T>& out,
             bool add = false) {
  constexpr int lanes = VectorOf<T>::kLanes;
  constexpr int panel = kCombineRows * lanes;
  const int count = a.count + p.count, tiles = (out.count + kCombineOut - 1) / kCombineOut;
  std::vector<const T*> from(count), plus(tiles * kCombineOut, nullptr);
  for (int i = 0; i < count; ++i) from[i] = i < a.count ? a.column(i) : p.column(i - a.count);
  std::vector<T> packed(static_cast<std::size_t>(tiles) * count * kCombineOut, T(0));
  for (int j = 0; j < out.count; ++j) {
    plus[j] = out.column(j);
    for (int i = 0; i < count; ++i) packed[(j / kCombineOut * count + i) * kCombineOut + j % kCombineOut] = m(i, j);
  }
  std::vector<T> result(static_cast<std::size_t>(tiles) * kCombineOut * panel);
  for (Eigen::Index row = 0; row < rows; row += panel) {
    const bool whole = row + panel <= rows;
    for (Eigen::Index part = row; part < std::min<Eigen::Index>(rows, row + panel); part += whole ? panel : lanes)
      for (int t = 0; t < tiles; ++t) {
        const int j = t * kCombineOut, n = std::min(kCombineOut, out.count - j);
        const T* tile = packed.data() + static_cast<std::size_t>(t) * count * kCombineOut;
        const T* const* addend = add ? plus.data() + j : nullptr;
        T* to = result.data() + static_cast<std::size_t>(j) * panel + (part - row);
        if (whole)
          combine_remainder<T, kCombineRows, kCombineOut>(n, from.data(), count, part, tile, addend, to, panel);
        else
          combine_remainder<T, 1, kCombineOut>(n, from.data(), count, part, tile, addend, to, panel);
      }
    const auto length = static_cast<std::size_t>(std::min<Eigen::Index>(panel, rows - row));
    for (int j = 0; j < out.count; ++j)
      std::memcpy(out.column(j) + row, result.data() + static_cast<std::size_t>(j) * panel, length * sizeof(T));
  }
}

}  // namespace sheen::row_panels
