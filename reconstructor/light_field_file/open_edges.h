// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace sheen {

/// Directed edges of a surface that grows, those that no triangle follows yet. By number: edge 3 t + k leaves corner k
/// of triangle t.
class OpenEdges {
 public:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  void add_vertex() {
    out_.push_back(kNone);
    in_.push_back(kNone);
  }
  /// Gives the edge's number.
  std::uint32_t add(std::uint32_t from, std::uint32_t to) {
    edges_.push_back({from, to, out_[from], in_[to], true});
    return out_[from] = in_[to] = static_cast<std::uint32_t>(edges_.size() - 1);
  }
  void close(std::uint32_t edge) { edges_[edge].open = false; }

  std::uint32_t from(std::uint32_t edge) const { return edges_[edge].from; }
  std::uint32_t to(std::uint32_t edge) const { return edges_[edge].to; }
  /// The newest that leaves a vertex, or reaches it; kNone where none is open.
  std::uint32_t out_of(std::uint32_t vertex) { return newest(out_[vertex], &Edge::next_out); }
  std::uint32_t into(std::uint32_t vertex) { return newest(in_[vertex], &Edge::next_in); }
  /// Looks at a few only: a surface has no more, and a hostile file is to cost no time.
  std::uint32_t between(std::uint32_t from, std::uint32_t to) const {
    std::uint32_t edge = out_[from];
    for (int looked = 0; edge != kNone && looked < kLooked; ++looked, edge = edges_[edge].next_out)
      if (edges_[edge].open && edges_[edge].to == to) return edge;
    return kNone;
  }

 private:
  static constexpr int kLooked = 32;
  struct Edge {
    std::uint32_t from, to, next_out, next_in;
    bool open;
  };

  /// Drops the closed ones before it.
  std::uint32_t newest(std::uint32_t& first, std::uint32_t Edge::*next) const {
    while (first != kNone && !edges_[first].open) first = edges_[first].*next;
    return first;
  }

  std::vector<Edge> edges_;
  std::vector<std::uint32_t> out_, in_;  ///< per vertex: the first of a list
};

}  // namespace sheen
