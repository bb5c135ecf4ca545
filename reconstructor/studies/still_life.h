// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "common/capture/capture.h"
#include "common/simulation/light_rig.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph_snapshot.h"

namespace sheen {

/// Intersection over union of two masks.
struct Overlap {
  std::size_t both = 0, either = 0;
  void add(bool a, bool b) {
    both += a && b;
    either += a || b;
  }
  double iou() const { return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 1; }
};

/// Images of all cameras of a rig in all of its lights, as a data set has them; the lights of a camera one after the
/// other.
std::vector<Capture> rig_captures(const LightRig& rig);

/// A simulated scene and the lumigraph of its images. Without `mesh` the images alone say where the surface is.
struct StillLife {
  StillLife(const LightRigOptions& options, std::shared_ptr<const Mesh> mesh);

  LightRig rig;
  std::shared_ptr<const IntrinsicLumigraphSnapshot> model;
};

/// What everything is compared with: linear interpolation of exact pictures in the two lights round a place of the row
/// (`LightRig::light_at`).
struct LinearPicture {
  ImageF radiance;  ///< RGB
  ImageF arrives;   ///< 0..1, 1 channel
};
LinearPicture interpolated_truth(const LightRig& rig, const PosedCamera& from, double place);

}  // namespace sheen
