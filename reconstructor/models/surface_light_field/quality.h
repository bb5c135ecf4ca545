// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "reconstructor/models/appearance_model.h"

namespace sheen {

struct RingSnapshot;

/// Quality of a ring, or of a triangle, for one direction (000 sec. 3.3). All in 0 (well known) .. 1 (not known).
struct RingQuality {
  bool seen = false;
  float projection = 1;   ///< psi_p: smoothed projection error of the online SVD, relative
  float hemisphere = 1;   ///< psi_h: area of the view-map triangle round the direction, relative
  float best_cosine = 0;  ///< of the most frontal image; 0..1

  /// Psi = omega sqrt(psi_p^2 + psi_h^2); omega = 1/sqrt(2) keeps it in 0..1. 1 where nothing was seen.
  float heuristic() const;
  QualityReason reason() const;
};

RingQuality assess_ring(const RingSnapshot& ring, const Eigen::Vector3f& direction);

/// A triangle is known as well as the mean of its rings, and is unseen when any of them is.
RingQuality combine(const RingQuality& a, const RingQuality& b, const RingQuality& c);

}  // namespace sheen
