// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/paper_heuristic.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

// A view-map triangle as large as this says that no image is near: views about 40 degrees apart.
constexpr float kSparseArea = 0.25f;
// A vertex whose new images still bring this fraction of their norm that the model did not know is as bad as can be.
constexpr float kHighResidual = 0.25f;

struct Terms {
  float projection = 1, hemisphere = 1;
  bool seen = false;
};

Terms assess(const SeenVertex& from, const ViewTriangulation& views, const Eigen::Vector3f& direction) {
  const ViewTriangulation::Location at = views.locate(hemisphere_point(from.views->frame, direction));
  return {.projection = std::min(1.0f, from.residual / kHighResidual),
          .hemisphere = at.triangle < 0 ? 1.0f : std::min(1.0f, views.area(at.triangle) / kSparseArea),
          .seen = true};
}

}  // namespace

PaperHeuristic::PaperHeuristic(const LightFieldSnapshot& snapshot, std::size_t every)
    : snapshot_(snapshot), views_(snapshot.mesh().vertices.size()) {
  tbb::parallel_for(std::size_t{0}, views_.size(), [&](std::size_t v) {
    const SeenVertex* from = snapshot_.seen_vertex(v);
    if (v % every == 0 && from) views_[v] = triangulate_views(from->views->frame, from->views->directions);
  });
}

float PaperHeuristic::of_vertex(std::size_t vertex, const Eigen::Vector3d& eye) const {
  const SeenVertex* from = snapshot_.seen_vertex(vertex);
  if (!from) return 1;
  const Terms terms =
      assess(*from, views_[vertex], (eye.cast<float>() - snapshot_.mesh().vertices[vertex]).normalized());
  return std::sqrt(0.5f * (terms.projection * terms.projection + terms.hemisphere * terms.hemisphere));
}

std::vector<float> PaperHeuristic::seen_from(const Eigen::Vector3d& eye) const {
  const Mesh& mesh = snapshot_.mesh();
  std::vector<Terms> terms(views_.size());
  tbb::parallel_for(std::size_t{0}, terms.size(), [&](std::size_t v) {
    if (const SeenVertex* from = snapshot_.seen_vertex(v))
      terms[v] = assess(*from, views_[v], (eye.cast<float>() - mesh.vertices[v]).normalized());
  });
  std::vector<float> heuristic;
  heuristic.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const float projection = (terms[a].projection + terms[b].projection + terms[c].projection) / 3;
    const float hemisphere = (terms[a].hemisphere + terms[b].hemisphere + terms[c].hemisphere) / 3;
    const bool seen = terms[a].seen && terms[b].seen && terms[c].seen;
    heuristic.push_back(seen ? std::sqrt(0.5f * (projection * projection + hemisphere * hemisphere)) : 1.0f);
  }
  return heuristic;
}

}  // namespace sheen
