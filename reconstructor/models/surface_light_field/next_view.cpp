// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/next_view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "reconstructor/models/surface_light_field/image_worth.h"
#include "reconstructor/models/surface_light_field/quality.h"

namespace sheen {
namespace {

constexpr int kCandidates = 48;
constexpr std::size_t kRingsLookedAt = 400;
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
    case QualityReason::kGood:
      break;
  }
  return "well covered";
}

}  // namespace

ViewAdvice advise_next_view(const SurfaceLightFieldSnapshot& snapshot, const Eigen::Vector3d& eye) {
  const Mesh& mesh = snapshot.mesh();
  const BoundingSphere bounds = bounding_sphere(mesh);
  const double distance = (eye - bounds.centre).norm();
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  const std::size_t stride = std::max<std::size_t>(1, mesh.vertices.size() / kRingsLookedAt);
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < kCandidates; ++i) places.push_back(bounds.centre + distance * candidate(i));
  const std::vector<double> worth = image_worth(snapshot, places);
  ViewAdvice best;
  best.eye = places[static_cast<std::size_t>(std::max_element(worth.begin(), worth.end()) - worth.begin())];
  double sum = 0, squared_error = 0, weight = 0;
  std::array<double, 5> by_reason{};
  for (std::size_t v = 0; v < mesh.vertices.size(); v += stride) {
    const Eigen::Vector3f direction = (best.eye.cast<float>() - mesh.vertices[v]).normalized();
    const double facing = normals[v].dot(direction);
    if (facing < 0.2) continue;
    SurfaceQuality quality;
    if (const RingSnapshot* ring = snapshot.ring_data()[v].get())
      quality = assess_ring(*ring, direction, snapshot.common_sill());
    sum += facing * quality.heuristic();
    squared_error += facing * quality.error * quality.error;
    weight += facing;
    by_reason[static_cast<std::size_t>(quality.reason())] += facing * quality.heuristic();
  }
  best.heuristic = weight > 0 ? sum / weight : 0;
  if (squared_error > 0) best.foretold_psnr_db = -10 * std::log10(squared_error / weight);
  const auto best_reason = static_cast<QualityReason>(
      std::distance(by_reason.begin(), std::max_element(by_reason.begin(), by_reason.end())));
  const Eigen::Vector3d from = (eye - bounds.centre).normalized(), to = (best.eye - bounds.centre).normalized();
  best.turn_deg = std::acos(std::clamp(from.dot(to), -1.0, 1.0)) * 180 / M_PI;
  best.reason = describe(best_reason);
  return best;
}

}  // namespace sheen
