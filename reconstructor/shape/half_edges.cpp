// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/half_edges.h"

#include <Eigen/Geometry>
#include <numeric>

namespace sheen {

HalfEdges::HalfEdges(std::span<const Triangle> triangles, std::size_t vertices)
    : leaving_(vertices, kNone), around_(vertices, 0), marked_(vertices, 0), triangles_(triangles.size()) {
  from_.reserve(3 * triangles.size());
  for (const Triangle& triangle : triangles)
    for (const std::uint32_t vertex : triangle) {
      leaving_[vertex] = static_cast<Id>(from_.size());
      ++around_[vertex];
      from_.push_back(vertex);
    }
  find_twins();
  for (std::uint32_t vertex = 0; vertex < vertices; ++vertex) in_fan_.push_back(is_closed_fan(vertex));
}

void HalfEdges::find_twins() {
  std::vector<Id> first(around_.size() + 1, 0), sorted(from_.size());  // half-edges by where they begin
  std::partial_sum(around_.begin(), around_.end(), first.begin() + 1);
  std::vector<Id> end(first.begin(), first.end() - 1);
  for (Id h = 0; h < from_.size(); ++h) sorted[end[from_[h]]++] = h;
  const auto only = [&](std::uint32_t a, std::uint32_t b) {  // from a to b
    Id found = kNone;
    for (Id i = first[a]; i < first[a + 1]; ++i) {
      if (to(sorted[i]) != b) continue;
      if (found != kNone) return kNone;
      found = sorted[i];
    }
    return found;
  };
  twin_.assign(from_.size(), kNone);
  for (Id h = 0; h < from_.size(); ++h) {
    const std::uint32_t a = from_[h], b = to(h);
    if (twin_[h] != kNone || a == b) continue;
    const Id other = only(b, a);
    if (other != kNone && only(a, b) == h) glue(h, other);
  }
}

void HalfEdges::glue(Id a, Id b) {
  twin_[a] = b;
  twin_[b] = a;
}

bool HalfEdges::is_closed_fan(std::uint32_t vertex) const {
  Id h = leaving_[vertex];
  for (std::uint32_t i = 0; i < around_[vertex]; ++i) {
    h = twin_[before(h)];
    if (h == kNone) return false;
    if (h == leaving_[vertex]) return i + 1 == around_[vertex];
  }
  return false;
}

bool HalfEdges::collapsible(Id h) {
  const std::uint32_t a = from(h), b = to(h);
  if (!in_fan_[a] || !in_fan_[b]) return false;
  if (around_[from(before(h))] < 4 || around_[from(before(twin_[h]))] < 4) return false;
  ++mark_;
  for_each_from(a, [&](Id leaving) { marked_[to(leaving)] = mark_; });
  int common = 0;
  for_each_from(b, [&](Id leaving) { common += marked_[to(leaving)] == mark_; });
  return common == 2;
}

void HalfEdges::collapse(Id h) {
  const Id t = twin_[h];
  const std::uint32_t a = from(h), b = to(h);
  around_[a] += around_[b] - 4;
  for_each_from(b, [&](Id leaving) { from_[leaving] = a; });
  for (const Id edge : {h, t}) {
    const Id inner = twin_[next(edge)], outer = twin_[before(edge)];
    const std::uint32_t corner = from(before(edge));
    glue(inner, outer);
    leaving_[corner] = inner;
    leaving_[a] = outer;
    --around_[corner];
    for (const Id dead : {edge, next(edge), before(edge)}) from_[dead] = kNone;
  }
  triangles_ -= 2;
}

}  // namespace sheen
