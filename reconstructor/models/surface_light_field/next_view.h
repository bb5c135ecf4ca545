// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {

/// A light field of which a picture from every place on offer is predicted to have this PSNR is well known: more images
/// change little that a person sees.
inline constexpr double kWellKnownDb = 32;

struct ViewAdvice {
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();  ///< object frame
  double heuristic = 0;                           ///< mean over the surface seen from there, 0 = nothing to gain .. 1
  double turn_deg = 0;                            ///< from the present eye, seen from the object
  std::string reason;                             ///< for a person: what is missing there
  double worst_psnr_db = 0;                       ///< predicted of a picture from the least known place on offer
  bool well_known() const { return worst_psnr_db >= kWellKnownDb; }
};

/// Where an image would be worth most (`image_worth`): a place on the sphere through the present eye, above the stage's
/// plane. Where that place is well known already, the least known one. Looks at a part of the rings, so that it can be
/// asked for several times a second.
ViewAdvice advise_next_view(const SurfaceLightFieldSnapshot& snapshot, const Eigen::Vector3d& eye);

}  // namespace sheen
