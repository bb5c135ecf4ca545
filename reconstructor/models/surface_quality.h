// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "reconstructor/surface/sample_state.h"

namespace sheen {

/// How well a part of the surface is known, and why it is not.
enum class QualityReason : std::uint8_t {
  kGood = 0,
  kUnseen = 1,            ///< no image shows it
  kOblique = 2,           ///< seen only at grazing angles
  kSparseDirections = 3,  ///< no image from near the asked direction
  kHighResidual = 4,      ///< images still bring what the model does not know
  kShapeGuessed = 5,      ///< of a shape that was found in the images: they do not show where it is
};

inline constexpr int kQualityReasons = 6;

/// What is known of a part of the surface from one direction.
struct SurfaceQuality {
  bool seen = false;
  float error = 0.14f;         ///< RMS of encoded values by which it is expected to be wrong; 0.14 of a guess
  float nearest_cosine = -1;   ///< of the angle to the nearest image's direction
  float best_cosine = 0;       ///< of the most frontal image; 0..1
  bool shape_guessed = false;  ///< where it is, no two images agree
  std::optional<float> another_heuristic;  ///< that is asked for in place of the error's, 0..1; of what was seen

  /// The quality heuristic, 0 = well known .. 1 = not at all: the error over 0.1 (20 dB) unless another is asked for;
  /// 1 where nothing was seen, and at least 0.5 where the shape is a guess.
  float heuristic() const;
  QualityReason reason() const;
};

/// One surface point as a model knows it.
struct SurfaceSample {
  Eigen::Vector3f rgb = Eigen::Vector3f::Zero();  ///< linear radiance
  SampleState state = SampleState::kUnseen;
};

/// Grey of the inside of an open object, sRGB-encoded: images of the outside say nothing of it.
inline constexpr float kInsideGrey = 0.35f;
SurfaceSample inside_sample();

}  // namespace sheen
