// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/rim_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "common/base/order_statistics.h"
#include "common/geometry/ray_scene.h"
#include "common/parallel/for_each.h"
#include "reconstructor/shape/outline_distance.h"
#include "reconstructor/shape/silhouette.h"

namespace sheen {
namespace {

constexpr float kOnRim = 0.35f;      // cosine of normal and sight, at most
constexpr float kOnRim_px = 2;       // from the rim of the mesh in a view
constexpr float kFarthest_px = 3;    // an outline that is farther away is another's
constexpr float kUnsure_px = 1.5f;   // between background and object: a rough outline, or none
constexpr float kBeyond_px = 0.75f;  // so far outside of a rim nothing of the mesh is
constexpr int kRounds = 2;           // the rim is elsewhere once it has moved
constexpr int kReach = 12;           // triangles, of a rim to what lies beside it
constexpr float kStiff = 8;          // weight of the neighbours, where a view on the rim has 1
constexpr float kStays = 0.15f;      // of a vertex for its own place

constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();

/// Where a mesh is, drawn as an outline.
ImageU8 drawn(const ShapeView& view, const RayScene& scene, const Eigen::Vector3d& origin) {
  const Silhouette silhouette(view, scene, origin);
  ImageU8 outline(view.outline.width(), view.outline.height(), 1);
  for (int y = 0; y < outline.height(); ++y)
    for (int x = 0; x < outline.width(); ++x)
      outline.at(x, y) = static_cast<std::uint8_t>(silhouette.has(x, y) ? Outline::kObject : Outline::kBackground);
  return outline;
}

/// Where the outline of one view is, seen from the vertices on the mesh's rim.
class RimView {
 public:
  RimView(const ShapeView& view, const RayScene& scene, const Eigen::Vector3d& origin)
      : scene_(scene),
        camera_(view.camera.camera),
        inside_(distance_from_rim(drawn(view, scene, origin), Outline::kObject)) {
    Rigid3 pose = view.camera.camera_from_object;
    pose.translation = pose * origin;
    rotation_ = pose.rotation.toRotationMatrix().cast<float>();
    translation_ = pose.translation.cast<float>();
    eye_ = camera_centre(pose).cast<float>();
    compare(distance_from_rim(view.outline, Outline::kUnknown), distance_from_rim(view.outline, Outline::kObject));
  }

  /// The way to it, metres along the normal; empty where the vertex is not on the rim.
  std::optional<float> outline_beyond(const Eigen::Vector3f& vertex, const Eigen::Vector3f& normal) const {
    if (inside_.empty()) return std::nullopt;
    const Eigen::Vector3f sight = (vertex - eye_).normalized();
    if (std::abs(sight.dot(normal)) > kOnRim) return std::nullopt;
    const Eigen::Vector3f p = rotation_ * vertex + translation_;
    if (!(p.z() > 0)) return std::nullopt;
    const auto fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
    const float x = fx * p.x() / p.z() + static_cast<float>(camera_.cx),
                y = fy * p.y() / p.z() + static_cast<float>(camera_.cy);
    if (!(x >= 2 && y >= 2 && x <= static_cast<float>(camera_.width - 3) &&
          y <= static_cast<float>(camera_.height - 3)))
      return std::nullopt;
    const float inside = bilinear(inside_, x, y), beyond = bilinear(beyond_, x, y);
    if (!(std::abs(inside) <= kOnRim_px && std::abs(beyond) <= kFarthest_px)) return std::nullopt;
    const float metres = p.z() / fx;
    const Eigen::Vector3f across = (normal - normal.dot(sight) * sight).normalized();
    const Eigen::Vector3f free = vertex + (kBeyond_px - std::min(0.0f, inside)) * metres * across;
    if (scene_.occluded({.origin = eye_, .direction = free - eye_})) return std::nullopt;
    return beyond * metres;
  }

 private:
  /// The same measure of both rims, so that one that is right stays to the bit.
  void compare(const ImageF& from_background, const ImageF& from_object) {
    if (inside_.empty() || from_background.empty() || from_object.empty()) {
      inside_ = {};
      return;
    }
    beyond_ = ImageF(inside_.width(), inside_.height(), 1);
    for (std::size_t i = 0; i < inside_.size(); ++i) {
      const bool sure = std::abs(from_background.data()[i] - from_object.data()[i]) <= kUnsure_px;
      beyond_.data()[i] = sure ? inside_.data()[i] - from_background.data()[i] : kNowhere;
    }
  }

  const RayScene& scene_;
  const Camera& camera_;
  ImageF inside_;  ///< pixels from the mesh's rim, negative on the mesh
  ImageF beyond_;  ///< pixels from there to the outline, positive outwards; NaN where no outline is sure
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f translation_, eye_;
};

/// How far the outlines are beyond each vertex, and how many views show it on a rim.
struct RimWays {
  std::vector<float> way;  ///< median over these, metres along the normal
  std::vector<float> views;
};

RimWays ways_to_outlines(std::span<const ShapeView> views, const Mesh& mesh,
                         const std::vector<Eigen::Vector3f>& normals) {
  const RayScene scene(mesh);
  std::vector<std::optional<RimView>> rims(views.size());
  in_parallel(views.size(), [&](std::size_t i) {
    if (!views[i].outline.empty()) rims[i].emplace(views[i], scene, mesh.origin);
  });
  RimWays ways{std::vector<float>(mesh.vertices.size(), 0), std::vector<float>(mesh.vertices.size(), 0)};
  in_parallel(mesh.vertices.size(), [&](std::size_t v) {
    std::vector<double> beyond;
    for (const std::optional<RimView>& rim : rims)
      if (const auto way = rim ? rim->outline_beyond(mesh.vertices[v], normals[v]) : std::nullopt)
        beyond.push_back(*way);
    if (beyond.empty()) return;
    ways.way[v] = static_cast<float>(median(beyond));
    ways.views[v] = static_cast<float>(beyond.size());
  });
  return ways;
}

/// What lies between rims follows them.
std::vector<float> spread(const RimWays& rims, const Mesh& mesh) {
  std::vector<float> way(rims.way.size(), 0);
  for (int round = 0; round < kReach; ++round) {
    std::vector<float> sum(way.size(), 0), count(way.size(), 0);
    for (const Triangle& t : mesh.triangles)
      for (int c = 0; c < 3; ++c) {
        sum[t[c]] += way[t[(c + 1) % 3]] + way[t[(c + 2) % 3]];
        count[t[c]] += 2;
      }
    for (std::size_t v = 0; v < way.size(); ++v)
      way[v] = (rims.views[v] * rims.way[v] + kStiff * sum[v] / std::max(1.0f, count[v])) /
               (rims.views[v] + kStiff + kStays);
  }
  return way;
}

}  // namespace

void move_rims_to_outlines(std::span<const ShapeView> views, double pixel, Mesh& mesh) {
  const auto most = static_cast<float>(pixel);
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
    const std::vector<float> way = spread(ways_to_outlines(views, mesh, normals), mesh);
    for (std::size_t v = 0; v < way.size(); ++v) mesh.vertices[v] += std::clamp(way[v], -most, most) * normals[v];
  }
}

}  // namespace sheen
