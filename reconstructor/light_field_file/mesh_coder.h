// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <optional>
#include <stdexcept>

#include "reconstructor/coding/context_coder.h"
#include "reconstructor/light_field_file/mesh_coding.h"
#include "reconstructor/light_field_file/open_edges.h"

/// How meshes are coded: one description that writing and reading share.
namespace sheen::mesh_coder {

using Point = GridMesh::Point;

constexpr std::uint32_t kNew = UINT32_MAX;  ///< a vertex that is not yet known
constexpr std::int32_t kFurthest = 1 << 22;
constexpr float kLargest = 1e15f;  ///< metres: squares of lengths stay finite
// A reader makes no more of a byte. A triangle takes two bits at least, each 1/177 of one at least.
constexpr std::size_t kTrianglesPerByte = 800;

struct Header {
  std::uint32_t triangles = 0;
  float origin[3] = {}, step = 1;
};

// Contexts, one range after the other.
constexpr int kSizes = 24, kGaps = 8, kValences = 8, kSteps = 5;
enum MeshContext : int {
  kBorder = 0,
  kBorderLast = kBorder + 4,
  kBeside = kBorderLast + kSteps * 4,  ///< two sides, each
  kBesideValence = kBeside + 2 * kGaps * kGaps,
  kBesideLast = kBesideValence + 2 * kGaps * kValences,
  kIsNew = kBesideLast + 2 * kGaps * kSteps,
  kNumber = kIsNew + 2,
  kPoint = kNumber + 1,
  kPointEdge = kPoint + 2 * kSizes * kSignedContexts,
  kMeshContexts = kPointEdge + 3 * kSizes * kSignedContexts,
};
enum MeshMixer : int {
  kBorderMixer = 0,
  kBesideMixer = kBorderMixer + 1,
  kPointMixer = kBesideMixer + 2,
  kMeshMixers = kPointMixer + kSignedContexts,
};

/// The triangles that are to be coded, found by their edges.
class Source {
 public:
  struct Third {
    std::uint32_t triangle, corner;  ///< behind the edge's
  };

  explicit Source(const GridMesh& mesh) : mesh_(mesh), new_vertex_(mesh.points.size(), kNew) {
    edges_.reserve(3 * mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::uint32_t k = 0; k < 3; ++k)
        edges_.push_back({mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3], t, k});
    std::sort(edges_.begin(), edges_.end());
    coded_.resize(mesh.triangles.size(), false);
  }

  /// A triangle not yet coded with an edge from `from` to `to`, vertices as they were coded.
  std::optional<Third> with_edge(std::uint32_t from, std::uint32_t to) const {
    const std::uint32_t old_from = old_vertex[from], old_to = old_vertex[to];
    for (auto edge = std::lower_bound(edges_.begin(), edges_.end(), Edge{old_from, old_to, 0, 0});
         edge != edges_.end() && edge->from == old_from && edge->to == old_to; ++edge)
      if (!coded_[edge->triangle]) return Third{edge->triangle, (edge->first + 2) % 3};
    return std::nullopt;
  }
  /// The first that is not yet coded.
  std::uint32_t next() {
    while (coded_[next_]) ++next_;
    return next_;
  }
  std::uint32_t known(std::uint32_t triangle, std::uint32_t corner) const {
    return new_vertex_[mesh_.triangles[triangle][corner]];
  }
  const Point& point(std::uint32_t triangle, std::uint32_t corner) const {
    return mesh_.points[mesh_.triangles[triangle][corner]];
  }
  void add_vertex(std::uint32_t triangle, std::uint32_t corner) {
    const std::uint32_t old = mesh_.triangles[triangle][corner];
    new_vertex_[old] = static_cast<std::uint32_t>(old_vertex.size());
    old_vertex.push_back(old);
  }
  void add_triangle(std::uint32_t triangle, std::uint32_t corner) {
    coded_[triangle] = true;
    old_triangle.push_back(triangle);
    first_corner.push_back(static_cast<std::uint8_t>(corner));
  }

  std::vector<std::uint32_t> old_vertex, old_triangle;  ///< in the order of the code
  std::vector<std::uint8_t> first_corner;

 private:
  struct Edge {
    std::uint32_t from, to, triangle, first;
    auto operator<=>(const Edge&) const = default;
  };
  const GridMesh& mesh_;
  std::vector<Edge> edges_;
  std::vector<bool> coded_;
  std::vector<std::uint32_t> new_vertex_;
  std::uint32_t next_ = 0;
};

/// Grows `mesh`. `source` is null where `coder` reads.
template <typename Coder>
class MeshCoder {
 public:
  MeshCoder(Coder& coder, GridMesh& mesh, Source* source) : coder_(coder), mesh_(mesh), source_(source) {}

  void code(std::size_t triangles) {
    while (mesh_.triangles.size() < triangles) {
      code_first_triangle();
      for (; !pivots_.empty(); pivots_.pop_front())
        for (std::uint32_t gate;
             mesh_.triangles.size() < triangles && (gate = open_.out_of(pivots_.front())) != OpenEdges::kNone;)
          code_beyond(gate);
    }
  }

 private:
  /// What followed an edge.
  enum class Step { kBorder, kLeft, kRight, kNewVertex, kOtherVertex };
  using Third = Source::Third;

  void code_first_triangle() {
    Third corner{source_ ? source_->next() : 0, 0};
    Triangle triangle{};
    for (std::uint32_t k = 0; k < 3; ++k) {
      corner.corner = k;
      const bool is_new = code_is_new(0, corner);
      const Point expected = k == 0 ? last_ : mesh_.points[triangle[0]];
      triangle[k] = is_new ? code_vertex(expected, false, 0, corner) : code_number_of(corner);
      pivots_.push_back(triangle[k]);
    }
    add(triangle, {corner.triangle, 0});
  }

  /// The triangle that follows an edge, if one does: its corners are the edge's end, its beginning and a third.
  void code_beyond(std::uint32_t gate) {
    const std::uint32_t a = open_.from(gate), b = open_.to(gate);
    std::optional<Third> wanted;
    if (source_) wanted = source_->with_edge(b, a);
    const int borders = border_[a] + 2 * border_[b];
    const std::array contexts = {kBorder + borders, kBorderLast + static_cast<int>(step_) * 4 + borders};
    if (coder_.bit(contexts, kBorderMixer, !wanted)) {
      open_.close(gate);
      border_[a] = border_[b] = true;
      step_ = Step::kBorder;
      return;
    }
    const Third corner = wanted.value_or(Third{});
    const std::uint32_t third = code_third(gate, corner);
    add({b, a, third}, {corner.triangle, (corner.corner + 1) % 3});
  }

  std::uint32_t code_third(std::uint32_t gate, const Third& wanted) {
    const std::uint32_t a = open_.from(gate), b = open_.to(gate), before = mesh_.triangles[gate / 3][(gate + 2) % 3];
    Point expected;
    for (std::size_t axis = 0; axis < 3; ++axis)
      expected[axis] =
          std::clamp(mesh_.points[a][axis] + mesh_.points[b][axis] - mesh_.points[before][axis], -kFurthest, kFurthest);
    const std::int64_t edge = squared_distance(mesh_.points[a], mesh_.points[b]);
    const std::uint32_t into = open_.into(a), out = open_.out_of(b);
    std::array<std::uint32_t, 2> beside = {into == OpenEdges::kNone ? kNew : open_.from(into),
                                           out == OpenEdges::kNone ? kNew : open_.to(out)};
    std::array<int, 2> gap;
    for (std::size_t side = 0; side < 2; ++side) {
      if (beside[side] == a || beside[side] == b || beside[side] == before) beside[side] = kNew;
      gap[side] = beside[side] == kNew ? kGaps - 1 : gap_of(mesh_.points[beside[side]], expected, edge);
    }
    const std::uint32_t known = source_ ? source_->known(wanted.triangle, wanted.corner) : 0;
    for (const int side : {0, 1}) {
      const std::uint32_t candidate = beside[static_cast<std::size_t>(side)];
      if (candidate == kNew || (side == 1 && candidate == beside[0])) continue;
      const int here = gap[static_cast<std::size_t>(side)] + side * kGaps,
                other = gap[static_cast<std::size_t>(1 - side)];
      const std::array contexts = {
          kBeside + here * kGaps + other,
          kBesideValence + here * kValences + std::min<int>(valence_[side == 0 ? a : b], kValences) - 1,
          kBesideLast + here * kSteps + static_cast<int>(step_),
      };
      if (!coder_.bit(contexts, kBesideMixer + side, known == candidate)) continue;
      step_ = side == 0 ? Step::kLeft : Step::kRight;
      return candidate;
    }
    if (code_is_new(1, wanted)) {
      step_ = Step::kNewVertex;
      const std::uint32_t vertex = code_vertex(expected, true, edge, wanted);
      pivots_.push_back(vertex);
      return vertex;
    }
    step_ = Step::kOtherVertex;
    return code_number_of(wanted);
  }

  /// How far a vertex is from where one is expected, beside the length of an edge.
  static int gap_of(const Point& point, const Point& expected, std::int64_t edge) {
    const std::int64_t distance = squared_distance(point, expected);
    int gap = 0;
    for (std::int64_t least = edge / 32; gap < kGaps - 2 && distance > least; least *= 2) ++gap;
    return gap;
  }

  bool code_is_new(int context, const Third& wanted) {
    return coder_.bit(kIsNew + context, source_ && source_->known(wanted.triangle, wanted.corner) == kNew);
  }

  std::uint32_t code_number_of(const Third& wanted) {
    const std::uint32_t number = source_ ? source_->known(wanted.triangle, wanted.corner) : 0;
    const auto known = static_cast<std::uint32_t>(mesh_.points.size());
    std::uint32_t read = 0;
    for (int i = std::bit_width(known) - 1; i >= 0; --i) read = 2 * read + coder_.bit(kNumber, (number >> i) & 1);
    if (read >= known) throw std::runtime_error("a triangle has a corner that is not a vertex");
    return read;
  }

  /// A difference from what is expected is about as large as those of late, and goes with the length of the edge.
  std::uint32_t code_vertex(const Point& expected, bool parallelogram, std::int64_t edge, const Third& wanted) {
    Point point{};
    if (source_) point = source_->point(wanted.triangle, wanted.corner);
    std::int32_t& size = size_[parallelogram];
    const int edge_size = std::min(static_cast<int>(std::bit_width(static_cast<std::uint64_t>(edge)) / 2), kSizes - 1);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int sizes = std::min<int>(std::bit_width(static_cast<std::uint32_t>(size)), kSizes - 1);
      const std::array contexts = {kPoint + (parallelogram * kSizes + sizes) * kSignedContexts,
                                   kPointEdge + (static_cast<int>(axis) * kSizes + edge_size) * kSignedContexts};
      const std::int32_t off = code_signed(coder_, contexts, kPointMixer, point[axis] - expected[axis]);
      point[axis] = std::clamp(expected[axis] + off, -kFurthest, kFurthest);
      size += std::min(std::abs(off), kFurthest) - size / 8;
    }
    if (source_) source_->add_vertex(wanted.triangle, wanted.corner);
    last_ = point;
    mesh_.points.push_back(point);
    open_.add_vertex();
    border_.push_back(false);
    valence_.push_back(0);
    return static_cast<std::uint32_t>(mesh_.points.size() - 1);
  }

  void add(const Triangle& triangle, const Third& first) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = triangle[k], to = triangle[(k + 1) % 3], reverse = open_.between(to, from);
      const std::uint32_t edge = open_.add(from, to);
      if (reverse != OpenEdges::kNone) {
        open_.close(reverse);
        open_.close(edge);
      }
      ++valence_[from];
    }
    mesh_.triangles.push_back(triangle);
    if (source_) source_->add_triangle(first.triangle, first.corner);
  }

  Coder& coder_;
  GridMesh& mesh_;
  Source* source_;
  OpenEdges open_;
  std::deque<std::uint32_t> pivots_;  ///< vertices whose edges are looked across next
  std::vector<bool> border_;          ///< per vertex: has an edge that nothing follows
  std::vector<std::uint32_t> valence_;
  Step step_ = Step::kNewVertex;
  Point last_{};
  std::int32_t size_[2] = {};  ///< of differences of late, eight times
};

}  // namespace sheen::mesh_coder
