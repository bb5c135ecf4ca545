// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "tracker/lights/ball_outline.h"

namespace sheen {

/// A light that a mirror ball shows.
struct Highlight {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit, from the ball; axes of a list of lights
  double uncertainty_deg =
      0;  ///< standard deviation of the angle, by noise, by the size of the highlight and by the outline
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< in the straightened picture
};

/// Finds the highlight of one light on a ball.
class HighlightFinder {
 public:
  struct Answer {
    std::optional<Highlight> highlight;
    std::string refusal;  ///< where there is none: a short, stable word; `refusal_text` explains it
  };

  /// `view` must outlive it. background: of `BallEvidence`, whose crop it is.
  HighlightFinder(const BallView& view, const BallOutline& outline, const BallCrop& crop, ImageF background);
  /// Linear light of a straightened picture. The light's direction is the mean of those that the highlight's pixels
  /// mirror. Of a ball that is far away each pixel mirrors the same solid angle, so that large lamps need no
  /// correction.
  Answer find(const ImageF& picture) const;

 private:
  double uncertainty_deg(const Eigen::Vector2d& place, double place_variance) const;

  const BallView& view_;
  BallOutline outline_;
  MirrorBall ball_;
  BallCrop crop_;
  ImageF background_;
  ImageU8 disc_;           ///< 255 inside the outline where the picture shows it
  ImageU8 beside_hidden_;  ///< 255 in the disc beside what the picture does not show
};

/// What a word of `Answer::refusal` means, for a person.
std::string refusal_text(const std::string& refusal);

}  // namespace sheen
