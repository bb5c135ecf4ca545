// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/quality.h"

#include <algorithm>
#include <cmath>

#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {
namespace {

// A view-map triangle as large as this says that no image is near: views about 40 degrees apart.
constexpr float kSparseArea = 0.25f;
// A ring whose new images still bring this share of their norm that the model did not know is as bad as can be.
constexpr float kHighResidual = 0.25f;
constexpr float kObliqueCosine = 0.35f;
constexpr float kGoodHeuristic = 0.25f;

}  // namespace

float RingQuality::heuristic() const {
  if (!seen) return 1;
  return std::min(1.0f, std::sqrt(0.5f * (projection * projection + hemisphere * hemisphere)));
}

QualityReason RingQuality::reason() const {
  if (!seen) return QualityReason::kUnseen;
  if (best_cosine < kObliqueCosine) return QualityReason::kOblique;
  if (heuristic() < kGoodHeuristic) return QualityReason::kGood;
  return hemisphere >= projection ? QualityReason::kSparseDirections : QualityReason::kHighResidual;
}

RingQuality assess_ring(const RingSnapshot& ring, const Eigen::Vector3f& direction) {
  RingQuality quality;
  if (ring.rank() == 0) return quality;
  quality.seen = true;
  quality.projection = std::min(1.0f, ring.residual / kHighResidual);
  const ViewTriangulation::Location at = ring.views.locate(hemisphere_point(ring.frame, direction));
  quality.hemisphere = at.triangle < 0 ? 1.0f : std::min(1.0f, ring.views.area(at.triangle) / kSparseArea);
  quality.best_cosine = ring.best_cosine;
  return quality;
}

RingQuality combine(const RingQuality& a, const RingQuality& b, const RingQuality& c) {
  return {a.seen && b.seen && c.seen, (a.projection + b.projection + c.projection) / 3,
          (a.hemisphere + b.hemisphere + c.hemisphere) / 3, std::max({a.best_cosine, b.best_cosine, c.best_cosine})};
}

}  // namespace sheen
