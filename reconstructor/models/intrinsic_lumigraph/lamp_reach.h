// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "reconstructor/lumigraph_file/lumigraph_data.h"
#include "reconstructor/models/intrinsic_lumigraph/seen_surface.h"

namespace sheen {

/// Which part of a surface a lamp's light reaches, as an eye sees it: over the footprint of a pixel of the view nearest
/// to it, by rays. There must be a view.
class LampReach {
 public:
  LampReach(const LumigraphData& data, std::shared_ptr<const Occluders> occluders, const Eigen::Vector3d& eye,
            const Lamp& lamp);
  /// Round a point of the surface, 0..1.
  float part(const Eigen::Vector3f& point) const;

 private:
  std::shared_ptr<const Occluders> occluders_;
  Eigen::Vector3f eye_;
  Lamp lamp_;
  Eigen::Matrix3f object_from_camera_;
  Eigen::Vector2f pixel_;  ///< width and height, at depth 1
};

}  // namespace sheen
