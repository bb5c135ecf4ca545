// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/capture_guidance.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>

#include "reconstructor/models/surface_light_field/image_worth.h"
#include "reconstructor/models/surface_light_field/light_field_snapshot.h"
#include "reconstructor/models/surface_light_field/paper_heuristic.h"
#include "reconstructor/models/surface_light_field/quality.h"

namespace sheen {
namespace {

class ByExpectedError : public CaptureGuidance {
 public:
  explicit ByExpectedError(const LightFieldSnapshot& snapshot) : snapshot_(snapshot) {}

  SurfaceQuality of_vertex(std::size_t vertex, const Eigen::Vector3d& eye) const override {
    const SeenVertex* from = snapshot_.seen_vertex(vertex);
    if (!from) return {};
    const Eigen::Vector3f direction = (eye.cast<float>() - snapshot_.mesh().vertices[vertex]).normalized();
    SurfaceQuality quality = assess_vertex(*from, direction, snapshot_.common_sill());
    quality.error = std::sqrt(quality.error * quality.error + snapshot_.missing_square());
    quality.shape_guessed = snapshot_.mesh().guessed_at(vertex);
    return quality;
  }

  std::vector<SurfaceQuality> of_triangles(const Eigen::Vector3d& eye) const override {
    const Mesh& mesh = snapshot_.mesh();
    std::vector<SurfaceQuality> vertices(mesh.vertices.size()), triangles;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices.size(), 64), [&](const auto& range) {
      for (std::size_t v = range.begin(); v < range.end(); ++v) vertices[v] = of_vertex(v, eye);
    });
    triangles.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      triangles.push_back(snapshot_.seen(t) ? combine(vertices[a], vertices[b], vertices[c]) : SurfaceQuality{});
    }
    return triangles;
  }

  std::vector<double> worth(std::span<const Eigen::Vector3d> eyes) const override {
    return image_worth(snapshot_, eyes);
  }

 private:
  const LightFieldSnapshot& snapshot_;
};

/// What is known beside the heuristic, the expected error and the reasons, stays.
class ByPaperHeuristic : public CaptureGuidance {
 public:
  ByPaperHeuristic(const LightFieldSnapshot& snapshot, std::size_t every)
      : snapshot_(snapshot), every_(every), expected_(snapshot), heuristic_(snapshot, every) {}

  SurfaceQuality of_vertex(std::size_t vertex, const Eigen::Vector3d& eye) const override {
    SurfaceQuality quality = expected_.of_vertex(vertex, eye);
    quality.another_heuristic = heuristic_.of_vertex(vertex, eye);
    return quality;
  }

  std::vector<SurfaceQuality> of_triangles(const Eigen::Vector3d& eye) const override {
    std::vector<SurfaceQuality> triangles = expected_.of_triangles(eye);
    const std::vector<float> heuristic = heuristic_.seen_from(eye);
    for (std::size_t t = 0; t < triangles.size(); ++t) triangles[t].another_heuristic = heuristic[t];
    return triangles;
  }

  /// The paper takes the image with the highest heuristic "from the point-of-view" of it (sec. 5.1).
  std::vector<double> worth(std::span<const Eigen::Vector3d> eyes) const override {
    const Mesh& mesh = snapshot_.mesh();
    const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
    std::vector<double> worth(eyes.size());
    tbb::parallel_for(std::size_t{0}, eyes.size(), [&](std::size_t e) {
      double sum = 0, weight = 0;
      for (std::size_t v = 0; v < normals.size(); v += every_) {
        const double facing = normals[v].dot((eyes[e].cast<float>() - mesh.vertices[v]).normalized());
        if (facing < kInSight) continue;
        sum += facing * heuristic_.of_vertex(v, eyes[e]);
        weight += facing;
      }
      worth[e] = weight > 0 ? sum / weight : 0;
    });
    return worth;
  }

 private:
  const LightFieldSnapshot& snapshot_;
  std::size_t every_;
  ByExpectedError expected_;
  PaperHeuristic heuristic_;
};

}  // namespace

std::unique_ptr<const CaptureGuidance> make_guidance(const LightFieldSnapshot& snapshot, std::size_t every) {
  if (snapshot.guidance_method() == GuidanceMethod::kPaperHeuristic)
    return std::make_unique<ByPaperHeuristic>(snapshot, every);
  return std::make_unique<ByExpectedError>(snapshot);
}

}  // namespace sheen
