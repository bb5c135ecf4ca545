// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "reconstructor/models/appearance_model.h"
#include "reconstructor/models/surface_light_field/snapshot.h"
#include "reconstructor/surface/map_layout.h"
#include "reconstructor/surface/sample_visibility.h"

namespace sheen {

/// Running mean of each surface sample's encoded colour over the images that show it: the model that knows no view
/// dependence. Every figure of a surface light field stands beside it.
class ConstantColour {
 public:
  ConstantColour(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const MapLayout> maps);

  /// encoded: as `resample` has it; only columns of visible samples are read. Log of how much brighter an image is than
  /// the mean, per triangle that both show; NaN elsewhere.
  std::vector<float> log_ratios(const SurfaceView& view, const Eigen::Matrix3Xf& encoded) const;
  void add(const SurfaceView& view, const Eigen::Matrix3Xf& encoded);
  void remove(const SurfaceView& view, const Eigen::Matrix3Xf& encoded);
  std::shared_ptr<const Appearance> snapshot(ExposureField exposure = {}) const;

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const MapLayout> maps_;
  Eigen::Matrix3Xf sum_;
  std::vector<std::uint32_t> count_;
};

}  // namespace sheen
