// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/mesh.h"

namespace sheen {

/// The triangles of a mesh by their half-edges, so that edges can be collapsed. Half-edge 3 t + c runs from corner c of
/// triangle t to its next corner; its twin runs the other way in the triangle beside it.
class HalfEdges {
 public:
  using Id = std::uint32_t;
  static constexpr Id kNone = UINT32_MAX;

  HalfEdges(std::span<const Triangle> triangles, std::size_t vertices);

  static Id next(Id h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static Id before(Id h) { return h % 3 == 0 ? h + 2 : h - 1; }
  Id twin(Id h) const { return twin_[h]; }
  std::uint32_t from(Id h) const { return from_[h]; }
  std::uint32_t to(Id h) const { return from_[next(h)]; }
  std::size_t size() const { return from_.size(); }
  bool gone(Id h) const { return from_[h] == kNone; }
  std::size_t triangles() const { return triangles_; }  ///< that are left

  /// Whether the triangles at a vertex are one closed fan. No edge of another vertex can be collapsed.
  bool in_fan(std::uint32_t vertex) const { return in_fan_[vertex]; }
  /// Calls `each(half-edge)` for those that begin at a vertex in a fan.
  template <typename Each>
  void for_each_from(std::uint32_t vertex, const Each& each) const {
    const Id first = leaving_[vertex];
    Id h = first;
    do {
      each(h);
      h = twin_[before(h)];
    } while (h != first);
  }

  /// Whether the surface stays a 2-manifold of the same genus: the link condition (Dey et al. 1999). Both ends have
  /// only the two corners beside the edge as common neighbours, and these keep three triangles.
  bool collapsible(Id h);
  /// The vertex at the end goes, and with it the two triangles of the edge.
  void collapse(Id h);

 private:
  void find_twins();
  bool is_closed_fan(std::uint32_t vertex) const;
  void glue(Id a, Id b);

  std::vector<std::uint32_t> from_;
  std::vector<Id> twin_;
  std::vector<Id> leaving_;            ///< per vertex a half-edge from it
  std::vector<std::uint32_t> around_;  ///< per vertex its triangles
  std::vector<std::uint8_t> in_fan_;
  std::vector<std::uint32_t> marked_;  ///< per vertex the last `mark_` that it was given
  std::uint32_t mark_ = 0;
  std::size_t triangles_;
};

}  // namespace sheen
