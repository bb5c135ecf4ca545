// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/one_piece.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "reconstructor/shape/sign_blocks.h"

namespace sheen {
namespace {

constexpr int kSide = SignBlocks::kSide, kWide = kSide + 1;
using Node = std::uint32_t;

/// Bit x: point x differs from the point before it, or is the first.
unsigned starts(unsigned row) {
  return 1 | (row ^ row << 1);
}

/// The pieces of either sign. Nodes are the blocks of one sign and the points of the others.
class Pieces {
 public:
  static constexpr Node kBeyond = 0;  ///< all that lies beyond the field

  explicit Pieces(const SignBlocks& signs) : signs_(signs), first_(signs.numbers(), kBeyond), parent_{kBeyond} {
    signs.for_each_block([&](std::size_t number) { add_nodes(number); });
    signs.for_each_block([&](std::size_t number) { join(number); });
    for (Node& parent : parent_) parent = parent_[parent];  // a parent has a lower number than its children
  }

  /// Calls `each(node, inside, points)` for all nodes in order.
  template <typename Each>
  void for_each_node(const Each& each) const {
    signs_.for_each_block([&](std::size_t number) {
      const SignBlocks::Rows* rows = signs_.rows(number);
      if (!rows) return each(first_[number], signs_.inside(number), BlockField::kBlockPoints);
      for (int i = 0; i < BlockField::kBlockPoints; ++i)
        each(first_[number] + i, (*rows)[i / kSide] >> i % kSide & 1, 1);
    });
  }

  Node piece(Node node) const { return parent_[node]; }  ///< told by its first node
  std::size_t nodes() const { return parent_.size(); }

  /// Lays the nodes inside for which `inside(node)`, the others outside.
  template <typename Inside>
  void lay(SignBlocks& signs, const Inside& inside) const {
    signs.for_each_block([&](std::size_t number) {
      Node node = first_[number];
      SignBlocks::Rows* rows = signs.rows(number);
      if (!rows) return signs.fill(number, inside(node));
      for (std::uint8_t& row : *rows) {
        row = 0;
        for (int x = 0; x < kSide; ++x) row |= static_cast<std::uint8_t>(inside(node++) << x);
      }
    });
  }

 private:
  /// The points of a run along x begin as one piece.
  void add_nodes(std::size_t number) {
    first_[number] = static_cast<Node>(parent_.size());
    const SignBlocks::Rows* rows = signs_.rows(number);
    if (!rows) return parent_.push_back(first_[number]);
    for (const unsigned row : *rows) {
      const unsigned started = starts(row);
      for (int x = 0; x < kSide; ++x)
        parent_.push_back(started >> x & 1 ? static_cast<Node>(parent_.size()) : parent_.back());
    }
  }

  /// The node of a point, 0 to kSide from the first point of a block.
  Node node(std::size_t number, int x, int y, int z) const {
    const std::size_t holder = signs_.holder(number, x, y, z);
    if (!signs_.rows(holder)) return first_[holder];
    return first_[holder] + BlockField::number_in_block({x % kSide, y % kSide, z % kSide});
  }

  /// Joins the points of a block with those of their upper neighbours that have the same sign.
  void join(std::size_t number) {
    if (signs_.of_one_sign(number)) {
      for (int corner = 1; corner < 8; ++corner)
        unite(first_[number],
              first_[signs_.holder(number, (corner & 1) * kSide, (corner >> 1 & 1) * kSide, (corner >> 2) * kSide)]);
      return;
    }
    const SignBlocks::WideRows rows = signs_.wide_rows(number);
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int corner = 1; corner < 8; ++corner) {
          const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
          const unsigned from = rows[y + kWide * z], to = rows[y + dy + kWide * (z + dz)] >> dx;
          // Runs that touch are joined where the first of their points touch.
          const unsigned touch = ~(from ^ to) & (corner == 1 ? 0x80u : starts(from) | starts(to)) & 0xff;
          for (unsigned left = touch; left != 0; left &= left - 1) {
            const int x = std::countr_zero(left);
            unite(node(number, x, y, z), node(number, x + dx, y + dy, z + dz));
          }
        }
  }

  Node root(Node node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }
  void unite(Node a, Node b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  const SignBlocks& signs_;
  std::vector<Node> first_;  ///< per block
  std::vector<Node> parent_;
};

/// Returns how many there were.
std::size_t fill_cavities(SignBlocks& signs) {
  const Pieces pieces(signs);
  std::vector<bool> filled(pieces.nodes(), false);
  std::size_t cavities = 0;
  pieces.for_each_node([&](Node node, bool inside, int) {
    const bool cavity = !inside && pieces.piece(node) != Pieces::kBeyond;
    filled[node] = inside || cavity;
    cavities += cavity && pieces.piece(node) == node;
  });
  if (cavities > 0) pieces.lay(signs, [&](Node node) { return filled[node]; });
  return cavities;
}

}  // namespace

PieceCounts make_one_piece(SignBlocks& signs) {
  PieceCounts counts{.cavities = fill_cavities(signs)};
  const Pieces pieces(signs);
  std::vector<std::uint32_t> points(pieces.nodes(), 0);
  std::size_t all = 0;
  pieces.for_each_node([&](Node node, bool inside, int more) {
    if (!inside) return;
    points[pieces.piece(node)] += more;
    all += more;
    counts.pieces += pieces.piece(node) == node;
  });
  if (counts.pieces < 2) return counts;
  const auto largest = static_cast<Node>(std::max_element(points.begin(), points.end()) - points.begin());
  pieces.lay(signs, [&](Node node) { return pieces.piece(node) == largest; });
  counts.left_out = 1 - static_cast<double>(points[largest]) / static_cast<double>(all);
  return counts;
}

}  // namespace sheen
