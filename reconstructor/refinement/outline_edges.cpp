// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/outline_edges.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "reconstructor/refinement/silhouette_rims.h"

namespace sheen {
namespace {

constexpr float kStep = 0.5f;       // between places, patch spacings
constexpr float kFullEdge = 0.06f;  // of encoded luminance: an edge so high counts half of the highest
constexpr int kAlong = 2;           // samples to either side along the outline, which an edge follows
constexpr int kApart = 3;           // places at which one edge does not show twice
constexpr int kFewestImages = 4;
constexpr float kLeastStrength = 0.25f;    // mean over the images, at the best place
constexpr float kLeastProminence = 1.25f;  // of it over the next best one elsewhere
constexpr int kElsewhere = 4;              // places apart
constexpr float kPull = 0.1f;              // of strength, from no displacement to the furthest place
constexpr float kSigma = 0.5f;             // patch spacings: standard deviation of an outline that was found

/// How strong an edge runs through a place of an image, across `out` (unit): 0 to 1; empty at the image's border.
std::optional<float> edge_strength(const GreyPyramid& image, int level, const Eigen::Vector2f& at,
                                   const Eigen::Vector2f& out, float width) {
  const Eigen::Vector2f along(-out.y(), out.x());
  float difference = 0;
  for (int i = -kAlong; i <= kAlong; ++i) {
    const Eigen::Vector2f inside = at + width * (float(i) * along - 0.5f * out), outside = inside + width * out;
    difference += image.sample(level, inside.x(), inside.y()) - image.sample(level, outside.x(), outside.y());
  }
  difference /= 2 * kAlong + 1;
  if (!std::isfinite(difference)) return {};
  const float square = difference * difference;
  return square / (square + kFullEdge * kFullEdge);
}

}  // namespace

OutlineEdges::OutlineEdges(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals,
                           std::span<const float> spacing)
    : mesh_(mesh), normals_(normals), spacing_(spacing), sums_(mesh.vertices.size()) {}

void OutlineEdges::add(const GreyPyramid& image, const PosedCamera& view, const RayScene& scene) {
  const Eigen::Vector3f eye = camera_centre(view.camera_from_object).cast<float>();
  const std::vector<bool> contour = on_contour(mesh_, eye);
  const double focal = std::sqrt(view.camera.fx * view.camera.fy);
  tbb::parallel_for(std::size_t{0}, mesh_.vertices.size(), [&](std::size_t v) {
    if (!contour[v] || !is_rim(mesh_.vertices[v], normals_[v], eye, focal, scene)) return;
    const auto project = [&](float place) {
      const Eigen::Vector3f point = mesh_.vertices[v] + place * spacing_[v] * normals_[v];
      return view.camera.project(view.camera_from_object * point.cast<double>());
    };
    const auto here = project(0), next = project(1);
    if (!here || !next) return;
    const Eigen::Vector2f step = (*next - *here).cast<float>();
    const float width = step.norm();
    if (!(width > 0)) return;
    const int level = image.level_for(width);
    std::array<float, kPlaces> strength;
    for (int k = 0; k < kPlaces; ++k) {
      const auto pixel = project(kStep * float(k - kReach));
      const auto found = pixel ? edge_strength(image, level, pixel->cast<float>(), step / width, width) : std::nullopt;
      if (!found) return;
      strength[k] = *found;
    }
    ++sums_[v].images;
    float beyond = 1;  // that there is none further out
    for (int k = kPlaces - 1; k >= 0; --k) {
      if (k + kApart < kPlaces) beyond *= 1 - strength[k + kApart];
      sums_[v].strength[k] += strength[k] * beyond;
    }
  });
}

Observations OutlineEdges::observe(const MeshEdges& edges) const {
  Observations observed(static_cast<Eigen::Index>(sums_.size()));
  for (std::size_t v = 0; v < sums_.size(); ++v) {
    Sums round = sums_[v];
    for (const std::uint32_t n : edges.around(v)) {
      round.images += sums_[n].images;
      for (int k = 0; k < kPlaces; ++k) round.strength[k] += sums_[n].strength[k];
    }
    if (sums_[v].images == 0 || round.images < kFewestImages) continue;
    const auto mean = [&](int k) {
      return round.strength[k] / float(round.images) - kPull * std::abs(float(k - kReach)) / kReach;
    };
    int best = 0;
    for (int k = 1; k < kPlaces; ++k)
      if (mean(k) > mean(best)) best = k;
    float elsewhere = 0;
    for (int k = 0; k < kPlaces; ++k)
      if (std::abs(k - best) >= kElsewhere) elsewhere = std::max(elsewhere, mean(k));
    if (best == 0 || best + 1 == kPlaces) continue;
    if (mean(best) < kLeastStrength || mean(best) < kLeastProminence * elsewhere) continue;
    const float before = mean(best - 1), after = mean(best + 1), bend = before + after - 2 * mean(best);
    const float place = float(best - kReach) + (bend < 0 ? std::clamp((before - after) / (2 * bend), -0.5f, 0.5f) : 0);
    const double spacing = spacing_[v];
    observed.add(static_cast<Eigen::Index>(v), kStep * place * spacing, 1 / std::pow(kSigma * spacing, 2));
  }
  return observed;
}

}  // namespace sheen
