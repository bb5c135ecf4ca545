// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/quality.h"

#include <algorithm>
#include <cmath>

#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {
namespace {

constexpr float kWorstError = 0.1f;
constexpr float kGoodHeuristic = 0.25f;  // 32 dB
constexpr float kObliqueCosine = 0.35f;
constexpr float kFarCosine = 0.94f;  // 20 degrees: an image from there would say something new
constexpr float kCommonViews = 1;    // images that the other rings' sills count for

}  // namespace

float SurfaceQuality::heuristic() const {
  return seen ? std::min(1.0f, error / kWorstError) : 1;
}

QualityReason SurfaceQuality::reason() const {
  if (!seen) return QualityReason::kUnseen;
  if (best_cosine < kObliqueCosine) return QualityReason::kOblique;
  if (heuristic() < kGoodHeuristic) return QualityReason::kGood;
  return nearest_cosine < kFarCosine ? QualityReason::kSparseDirections : QualityReason::kHighResidual;
}

SurfaceQuality assess_ring(const RingSnapshot& ring, const Eigen::Vector3f& direction, float common_sill) {
  SurfaceQuality quality;
  const auto shown = [](std::uint8_t share) { return share > 0; };
  if (ring.rank() == 0 || ring.directions.cols() == 0 || std::none_of(ring.shown.begin(), ring.shown.end(), shown))
    return quality;
  quality.seen = true;
  const auto views = static_cast<float>(ring.directions.cols());
  const float sill = (views * ring.sill + kCommonViews * common_sill) / (views + kCommonViews);
  quality.error = std::sqrt(sill * prediction_variance(ring.directions, ring.kernel, direction));
  quality.nearest_cosine = (ring.directions.transpose() * direction).maxCoeff();
  quality.best_cosine = ring.best_cosine;
  return quality;
}

SurfaceQuality combine(const SurfaceQuality& a, const SurfaceQuality& b, const SurfaceQuality& c) {
  if (!a.seen || !b.seen || !c.seen) return {};
  return {true, (a.error + b.error + c.error) / 3, std::max({a.nearest_cosine, b.nearest_cosine, c.nearest_cosine}),
          std::max({a.best_cosine, b.best_cosine, c.best_cosine})};
}

}  // namespace sheen
