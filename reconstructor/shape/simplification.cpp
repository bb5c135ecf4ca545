// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/simplification.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>

#include "reconstructor/shape/half_edges.h"
#include "reconstructor/shape/quadric.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

/// What a squared distance from where the vertices were counts, beside one from their planes. It spreads the triangles
/// where the surface is flat.
constexpr double kRegularity = 1e-5;
/// Of the bounding radius: the root mean square distance from the planes of the triangles that a vertex stands for.
/// What would go farther stays: a part that cannot get simpler, such as a sponge, must not cost the others their shape.
constexpr double kFarthest = 0.01;
/// A triangle turns by at most 80 degrees in a collapse.
constexpr double kLeastCosine = 0.17;
/// Slimmer triangles come up only where there were such. 1: all sides are equal; 0: no area.
constexpr double kSlim = 0.02;

/// Two, by the corners of a triangle.
struct Facet {
  Facet(const Vector3d& a, const Vector3d& b, const Vector3d& c)
      : area_normal((b - a).cross(c - a)),
        shape(2 * std::sqrt(3.0) * area_normal.norm() /
              ((b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm())) {}
  Vector3d area_normal;  ///< twice the area long
  double shape;
};

struct Collapse {
  HalfEdges::Id edge;
  std::uint32_t version;  ///< of its two ends, when the cost was found
};

/// The cheapest first, to within an eighth of the cost: of those that cost about the same the one that came last. All
/// collapses of a large mesh do not fit into the cache, and a heap of them is slow.
class CollapseQueue {
 public:
  bool empty() const { return size_ == 0; }
  void push(float cost, const Collapse& collapse) {
    const std::size_t bucket = std::bit_cast<std::uint32_t>(cost) >> 20;  // the exponent and three bits
    buckets_[bucket].push_back(collapse);
    first_ = std::min(first_, bucket);
    ++size_;
  }
  Collapse pop() {
    while (buckets_[first_].empty()) ++first_;
    const Collapse collapse = buckets_[first_].back();
    buckets_[first_].pop_back();
    --size_;
    return collapse;
  }

 private:
  std::vector<std::deque<Collapse>> buckets_ = std::vector<std::deque<Collapse>>(2048);
  std::size_t first_ = 2048, size_ = 0;
};

class Simplification {
 public:
  Simplification(const Mesh& mesh, std::span<const float> detail)
      : edges_(mesh.triangles, mesh.vertices.size()), sphere_(bounding_sphere(mesh)) {
    const double unit = sphere_.radius > 0 ? 1 / sphere_.radius : 1;
    place_.reserve(mesh.vertices.size());
    for (const Eigen::Vector3f& vertex : mesh.vertices)
      place_.push_back(unit * (vertex.cast<double>() - sphere_.centre));
    version_.assign(place_.size(), 0);
    add_quadrics(mesh, detail);
    for (HalfEdges::Id h = 0; h < edges_.size(); ++h)
      if (edges_.twin(h) != HalfEdges::kNone && h < edges_.twin(h)) offer(h);
  }

  void run(std::size_t triangles) {
    while (edges_.triangles() > triangles && !queue_.empty()) {
      const Collapse next = queue_.pop();
      if (edges_.gone(next.edge) || version(next.edge) != next.version || !edges_.collapsible(next.edge)) continue;
      const Vector3d place = joint_quadric(next.edge).least();
      if (keeps_shape(next.edge, place)) collapse(next.edge, place);
    }
  }

  Mesh mesh(const Vector3d& origin, std::span<const ShapeEvidence> evidence) const {
    Mesh result{.vertices = {}, .triangles = {}, .origin = origin};
    std::vector<std::uint32_t> now(place_.size(), HalfEdges::kNone);
    for (HalfEdges::Id h = 0; h < edges_.size(); ++h)
      if (!edges_.gone(h)) now[edges_.from(h)] = 0;
    for (std::size_t v = 0; v < now.size(); ++v) {
      if (now[v] == HalfEdges::kNone) continue;
      now[v] = static_cast<std::uint32_t>(result.vertices.size());
      if (!evidence.empty()) result.evidence.push_back(evidence[v]);
      const double scale = sphere_.radius > 0 ? sphere_.radius : 1;
      result.vertices.push_back((scale * place_[v] + sphere_.centre).cast<float>());
    }
    for (HalfEdges::Id h = 0; h < edges_.size(); h += 3)
      if (!edges_.gone(h))
        result.triangles.push_back({now[edges_.from(h)], now[edges_.from(h + 1)], now[edges_.from(h + 2)]});
    return result;
  }

 private:
  void add_quadrics(const Mesh& mesh, std::span<const float> detail) {
    quadrics_.resize(place_.size());
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vector3d area_normal = (place_[b] - place_[a]).cross(place_[c] - place_[a]);
      const double length = area_normal.norm();
      if (!(length > 0)) continue;
      for (const std::uint32_t v : {a, b, c}) {
        const double weight = length / 6 * (detail.empty() ? 1 : detail[v]);
        quadrics_[v].add_plane(area_normal / length, place_[v], weight);
        quadrics_[v].add_point(place_[v], kRegularity * weight);
      }
    }
  }

  std::uint32_t version(HalfEdges::Id h) const { return version_[edges_.from(h)] + version_[edges_.to(h)]; }
  Quadric joint_quadric(HalfEdges::Id h) const {
    Quadric sum = quadrics_[edges_.from(h)];
    return sum += quadrics_[edges_.to(h)];
  }
  void offer(HalfEdges::Id h) {
    if (!edges_.in_fan(edges_.from(h)) || !edges_.in_fan(edges_.to(h))) return;
    const Quadric sum = joint_quadric(h);
    const double cost = sum.at(sum.least());
    if (cost > kFarthest * kFarthest * sum.weight) return;
    queue_.push(cost > 0 ? static_cast<float>(cost) : 0, {h, version(h)});
  }

  /// Whether no triangle turns over and none becomes a sliver.
  bool keeps_shape(HalfEdges::Id edge, const Vector3d& place) const {
    const HalfEdges::Id first = edge / 3, second = edges_.twin(edge) / 3;
    bool turns = false;
    double slimmest_before = 1, slimmest_after = 1;
    for (const std::uint32_t end : {edges_.from(edge), edges_.to(edge)})
      edges_.for_each_from(end, [&](HalfEdges::Id h) {
        const Vector3d &b = place_[edges_.to(h)], &c = place_[edges_.from(HalfEdges::before(h))];
        const Facet old(place_[end], b, c);
        slimmest_before = std::min(slimmest_before, old.shape);
        if (h / 3 == first || h / 3 == second) return;
        const Facet moved(place, b, c);
        slimmest_after = std::min(slimmest_after, moved.shape);
        turns = turns || !(old.area_normal.dot(moved.area_normal) >=
                           kLeastCosine * old.area_normal.norm() * moved.area_normal.norm());
      });
    return !turns && slimmest_after > 0 && slimmest_after >= std::min(kSlim, slimmest_before);
  }

  void collapse(HalfEdges::Id edge, const Vector3d& place) {
    const std::uint32_t stays = edges_.from(edge), goes = edges_.to(edge);
    quadrics_[stays] += quadrics_[goes];
    place_[stays] = place;
    version_[stays] = std::max(version_[stays], version_[goes]) + 1;  // new for all its edges
    edges_.collapse(edge);
    edges_.for_each_from(stays, [&](HalfEdges::Id h) { offer(h); });
  }

  HalfEdges edges_;
  BoundingSphere sphere_;
  std::vector<Vector3d> place_;  ///< in radii from the centre of the sphere
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> version_;
  CollapseQueue queue_;
};

}  // namespace

Mesh simplified(Mesh mesh, std::size_t triangles, std::span<const float> detail) {
  Simplification simplification(mesh, detail);
  const Vector3d origin = mesh.origin;
  const std::vector<ShapeEvidence> evidence = std::move(mesh.evidence);
  mesh = {};  // memory: a field of many cells has a surface of millions of triangles
  simplification.run(triangles);
  return simplification.mesh(origin, evidence);
}

}  // namespace sheen
