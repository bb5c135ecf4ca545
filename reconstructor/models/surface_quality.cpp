// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_quality.h"

#include <algorithm>

#include "common/image/color.h"

namespace sheen {
namespace {

constexpr float kWorstError = 0.1f;
constexpr float kGoodHeuristic = 0.25f;  // 32 dB
constexpr float kOfGuessedShape = 0.5f;  // 26 dB
constexpr float kObliqueCosine = 0.35f;
constexpr float kFarCosine = 0.94f;  // 20 degrees: an image from there would say something new

}  // namespace

float SurfaceQuality::heuristic() const {
  if (!seen) return 1;
  const float of_colour = another_heuristic.value_or(std::min(1.0f, error / kWorstError));
  return shape_guessed ? std::max(of_colour, kOfGuessedShape) : of_colour;
}

QualityReason SurfaceQuality::reason() const {
  if (!seen) return QualityReason::kUnseen;
  if (best_cosine < kObliqueCosine) return QualityReason::kOblique;
  if (shape_guessed) return QualityReason::kShapeGuessed;
  if (heuristic() < kGoodHeuristic) return QualityReason::kGood;
  return nearest_cosine < kFarCosine ? QualityReason::kSparseDirections : QualityReason::kHighResidual;
}

SurfaceSample inside_sample() {
  return {Eigen::Vector3f::Constant(srgb_decode(kInsideGrey)), SampleState::kUnseen};
}

}  // namespace sheen
