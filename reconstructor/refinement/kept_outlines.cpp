// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/kept_outlines.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "common/geometry/ray_scene.h"
#include "common/registration/silhouette.h"

namespace sheen {
namespace {

constexpr float kStep_px = 0.25f;  // by which vertices go back at a time
constexpr int kSteps = 8;
constexpr int kReach_px = 8;  // within which the outline is looked for that belongs to an uncovered pixel

/// The pixel of a silhouette that is nearest to (x, y), within kReach_px.
std::optional<Eigen::Vector2d> nearest_covered(const ImageU8& silhouette, int x, int y) {
  std::optional<Eigen::Vector2d> nearest;
  int least = kReach_px * kReach_px + 1;
  for (int v = std::max(0, y - kReach_px); v <= std::min(silhouette.height() - 1, y + kReach_px); ++v)
    for (int u = std::max(0, x - kReach_px); u <= std::min(silhouette.width() - 1, x + kReach_px); ++u) {
      const int squared = (u - x) * (u - x) + (v - y) * (v - y);
      if (silhouette.at(u, v) == 0 || squared >= least) continue;
      least = squared;
      nearest = Eigen::Vector2d(u, v);
    }
  return nearest;
}

/// Marks the vertices that left pixels of a mask uncovered which the given mesh covers: those of the outline beside it
/// that moved inward. False where there are none.
bool mark_uncovered(const ImageU8& mask, const PosedCamera& view, const ImageU8& given, const ImageU8& covered,
                    const RayScene& scene, const RefinedMesh& refined, std::vector<bool>& marked) {
  const Rigid3 object_from_camera = view.camera_from_object.inverse();
  bool any = false;
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x) {
      if (mask.at(x, y) == 0 || given.at(x, y) == 0 || covered.at(x, y) != 0) continue;
      const auto beside = nearest_covered(covered, x, y);
      if (!beside) continue;
      const Eigen::Vector3d ray = object_from_camera.rotation * *view.camera.ray(*beside);
      const Hit hit = scene.intersect(Ray{object_from_camera.translation.cast<float>(), ray.cast<float>()});
      if (!hit) continue;
      for (const std::uint32_t v : refined.mesh.triangles[hit.triangle])
        if (refined.moved[v] < 0) any = marked[v] = true;
    }
  return any;
}

void take_back(const Mesh& given, std::size_t vertex, float by, RefinedMesh& refined) {
  const float moved = std::abs(refined.moved[vertex]);
  const float kept = moved > by ? 1 - by / moved : 0;
  refined.moved[vertex] *= kept;
  refined.mesh.vertices[vertex] =
      given.vertices[vertex] + kept * (refined.mesh.vertices[vertex] - given.vertices[vertex]);
}

}  // namespace

void keep_outlines_covered(const Mesh& given, const RefinementImages& images, std::span<const float> footprints,
                           RefinedMesh& refined) {
  const RayScene given_scene(given);
  SilhouetteCaster caster;
  std::vector<std::size_t> to_check(images.cameras.size());
  std::iota(to_check.begin(), to_check.end(), std::size_t{0});
  for (int step = 0; step < kSteps && !to_check.empty(); ++step) {
    const RayScene scene(refined.mesh);
    std::vector<bool> marked(given.vertices.size(), false);
    std::vector<std::size_t> uncovered;
    for (const std::size_t i : to_check) {
      const Capture capture = images.read(i);
      const PosedCamera& view = images.cameras[i];
      if (!capture.mask.empty() && mark_uncovered(capture.mask, view, caster.cast(view, given, given_scene),
                                                  caster.cast(view, refined.mesh, scene), scene, refined, marked))
        uncovered.push_back(i);
    }
    for (std::size_t v = 0; v < marked.size(); ++v)
      if (marked[v]) take_back(given, v, kStep_px * footprints[v], refined);
    to_check = std::move(uncovered);
  }
}

}  // namespace sheen
