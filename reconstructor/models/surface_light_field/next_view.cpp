// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/next_view.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/angle.h"
#include "reconstructor/models/surface_light_field/capture_guidance.h"

namespace sheen {
namespace {

constexpr int kCandidates = 48;
constexpr std::size_t kVerticesLookedAt = 200;
constexpr double kLowest = 0.15;  // sine of the elevation: a camera needs room above the stage
constexpr double kHighest = 0.97;

/// Evenly spread over the cap by the golden angle.
Eigen::Vector3d candidate(int i) {
  const double z = kLowest + (kHighest - kLowest) * (i + 0.5) / kCandidates;
  const double angle = i * M_PI * (3 - std::sqrt(5.0)), r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

const char* describe(QualityReason reason) {
  switch (reason) {
    case QualityReason::kUnseen:
      return "surface not seen yet";
    case QualityReason::kOblique:
      return "surface seen only at grazing angles";
    case QualityReason::kSparseDirections:
      return "few images from there";
    case QualityReason::kHighResidual:
      return "images there still bring news";
    case QualityReason::kShapeGuessed:
      return "its shape is a guess there";
    case QualityReason::kGood:
      break;
  }
  return "well covered";
}

/// How well the surface in sight of a place is known from there.
struct Prospect {
  double heuristic = 0, psnr_db = 0;
  QualityReason reason = QualityReason::kGood;  ///< which has most of the heuristic
};

Prospect prospect_from(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, std::size_t stride,
                       const CaptureGuidance& guidance, const Eigen::Vector3d& eye) {
  double sum = 0, squared_error = 0, weight = 0;
  std::array<double, kQualityReasons> by_reason{};
  for (std::size_t v = 0; v < mesh.vertices.size(); v += stride) {
    const double facing = normals[v].dot((eye.cast<float>() - mesh.vertices[v]).normalized());
    if (facing < kInSight) continue;
    const SurfaceQuality quality = guidance.of_vertex(v, eye);
    sum += facing * quality.heuristic();
    squared_error += facing * quality.error * quality.error;
    weight += facing;
    by_reason[static_cast<std::size_t>(quality.reason())] += facing * quality.heuristic();
  }
  Prospect prospect;
  prospect.heuristic = weight > 0 ? sum / weight : 0;
  if (squared_error > 0) prospect.psnr_db = -10 * std::log10(squared_error / weight);
  prospect.reason = static_cast<QualityReason>(
      std::distance(by_reason.begin(), std::max_element(by_reason.begin(), by_reason.end())));
  return prospect;
}

}  // namespace

ViewAdvice advise_next_view(const LightFieldSnapshot& snapshot, const Eigen::Vector3d& eye) {
  const Mesh& mesh = snapshot.mesh();
  const BoundingSphere bounds = bounding_sphere(mesh);
  const double distance = (eye - bounds.centre).norm();
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  const std::size_t stride = std::max<std::size_t>(1, mesh.vertices.size() / kVerticesLookedAt);
  const std::unique_ptr<const CaptureGuidance> guidance = make_guidance(snapshot, stride);
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < kCandidates; ++i) places.push_back(bounds.centre + distance * candidate(i));
  std::vector<Prospect> prospects(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(),
                    [&](std::size_t i) { prospects[i] = prospect_from(mesh, normals, stride, *guidance, places[i]); });
  const std::vector<double> worth = guidance->worth(places);
  const auto worst = static_cast<std::size_t>(
      std::min_element(prospects.begin(), prospects.end(),
                       [](const Prospect& a, const Prospect& b) { return a.psnr_db < b.psnr_db; }) -
      prospects.begin());
  auto best = static_cast<std::size_t>(std::max_element(worth.begin(), worth.end()) - worth.begin());
  if (prospects[best].psnr_db >= kWellKnownDb) best = worst;
  ViewAdvice advice{.eye = places[best],
                    .heuristic = prospects[best].heuristic,
                    .reason = describe(prospects[best].reason),
                    .worst_psnr_db = prospects[worst].psnr_db};
  const Eigen::Vector3d from = (eye - bounds.centre).normalized(), to = (advice.eye - bounds.centre).normalized();
  advice.angle_deg = std::acos(std::clamp(from.dot(to), -1.0, 1.0)) / kDegree;
  return advice;
}

}  // namespace sheen
