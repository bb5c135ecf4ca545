// SPDX-License-Identifier: Apache-2.0
#include "common/registration/placement_check.h"

#include <algorithm>
#include <cmath>

#include "common/base/format.h"
#include "common/base/order_statistics.h"
#include "common/registration/frame_mistakes.h"
#include "common/registration/outline_evidence.h"
#include "common/registration/texture_evidence.h"

namespace sheen {
namespace {

constexpr double kBelowStage = 0.02;     // of the mesh's height: what a scan's noise reaches below the plane
constexpr double kOutlineOff_px = 3;     // median distance of the outlines; a mesh that is refined later has less
constexpr double kHardlyAgree = 0.25;    // mean correlation at half size; photographs of right meshes have 0.4 and more
constexpr double kAgreeBetter = 0.12;    // more of it: the mesh stands there rather than here
constexpr double kStep = 0.05;           // of the mesh's radius
constexpr int kRounds = 4;               // of the search: how many steps away it looks
constexpr std::size_t kFewPoints = 200;  // about which images agree: fewer say nothing
constexpr int kLevel = 1;
constexpr double kMargin_px = 2;
constexpr const char* kOnStage = "`sheen-tracker register` puts it right";
constexpr const char* kOfPhotographs =
    "take mesh and poses from one reconstruction, or register the mesh to it in the program that made it";

/// What speaks against where a mesh stands.
struct Doubt {
  std::string what;       ///< empty: nothing
  bool by_itself = true;  ///< else it counts only where a mistake of frames explains it
};

Doubt below_stage(const Mesh& mesh) {
  float lowest = HUGE_VALF, highest = -HUGE_VALF;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    lowest = std::min(lowest, v.z());
    highest = std::max(highest, v.z());
  }
  if (lowest >= -kBelowStage * (highest - lowest)) return {};
  return {
      format("the mesh reaches %.3g mm below the stage: it is in another frame than the stage's, whose z points up "
             "(many files have y up)",
             -1e3 * lowest)};
}

Doubt outlines_off(const OutlineEvidence& outlines) {
  std::vector<double> distances = outlines.distances(Similarity{});
  for (double& d : distances) d = std::abs(d);
  if (distances.empty()) return {"no image shows the mesh's outline, though there are masks"};
  const double off = median(distances);
  if (off < kOutlineOff_px) return {};
  return {format(
      "the mesh's outline is %.1f pixels from that of the masks (median): it does not stand where the object is", off)};
}

Doubt texture_off(const Mesh& mesh, const RayScene& scene, std::span<const RegistrationImage> images) {
  TextureEvidence texture(mesh, scene, images, kLevel);
  const auto agreement = [&](const Eigen::Vector3d& offset) {
    Similarity place;
    place.translation = offset;
    texture.see(place, kLevel, kMargin_px);
    return texture.agreement(place);
  };
  const TextureEvidence::Agreement here = agreement(Eigen::Vector3d::Zero());
  if (here.points < kFewPoints) return {"hardly two images show the same part of the mesh", false};
  const double step = kStep * bounding_sphere(mesh).radius;
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double most = here.correlation;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector3d from = best;
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0}) {
        const Eigen::Vector3d there = from + sign * step * Eigen::Vector3d::Unit(axis);
        const TextureEvidence::Agreement found = agreement(there);
        if (2 * found.points < here.points || found.correlation <= most) continue;
        most = found.correlation;
        best = there;
      }
    if (best == from) break;
  }
  if (most > here.correlation + kAgreeBetter)
    return {format("the images agree better about the mesh when it is moved by about (%.0f, %.0f, %.0f) mm",
                   1e3 * best.x(), 1e3 * best.y(), 1e3 * best.z()) +
            format(" (correlation %.2f, as it stands %.2f)", most, here.correlation)};
  if (here.correlation < kHardlyAgree)
    return {format(
        "the images hardly agree about the mesh's surface (correlation %.2f): it does not stand where the object is, "
        "is another object's, or shines like a mirror",
        here.correlation)};
  return {};
}

Doubt doubt_of(const Mesh& mesh, std::span<const RegistrationImage> images, bool on_stage) {
  if (on_stage)
    if (Doubt found = below_stage(mesh); !found.what.empty()) return found;
  const RayScene scene(mesh);
  const OutlineEvidence outlines(mesh, scene, images, Similarity{});
  return outlines.any() ? outlines_off(outlines) : texture_off(mesh, scene, images);
}

}  // namespace

PlacementWarning placement_warning(const Mesh& mesh, std::span<const RegistrationImage> images,
                                   const PlacementFacts& facts) {
  const Doubt doubt = doubt_of(mesh, images, facts.on_stage);
  if (doubt.what.empty()) return {};
  const std::vector<RegistrationImage> more = facts.more ? facts.more() : std::vector<RegistrationImage>{};
  const auto mistake = find_frame_mistake(mesh, more.empty() ? images : more, facts.applied);
  if (mistake) return {doubt.what + "; " + in_words(*mistake), true};
  if (!doubt.by_itself) return {};
  return {doubt.what + "; " + (facts.on_stage ? kOnStage : kOfPhotographs)};
}

}  // namespace sheen
