// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "reconstructor/models/appearance_model.h"
#include "reconstructor/models/surface_light_field/patch_column.h"
#include "reconstructor/models/surface_light_field/snapshot.h"
#include "reconstructor/radiance/resampling.h"
#include "reconstructor/surface/map_layout.h"

namespace sheen {

/// Running mean of each surface sample's encoded colour over the images that show it: the model that knows no view
/// dependence. Every figure of a surface light field stands beside it.
class ConstantColour {
 public:
  ConstantColour(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const MapLayout> maps);

  /// Log of how much brighter an image is than the mean, per triangle that both show; NaN elsewhere.
  std::vector<float> log_ratios(const SurfaceImage& image) const;
  void add(const SurfaceImage& image);
  /// What an image showed of a patch. Different patches may be added and removed at the same time.
  void add(const PatchShape& patch, const PatchColumn& column);
  void remove(const PatchShape& patch, const PatchColumn& column);
  std::shared_ptr<const Appearance> snapshot(ExposureField exposure = {}) const;

 private:
  void add(std::size_t triangle, std::span<const std::uint8_t> visible,
           const Eigen::Ref<const Eigen::Matrix3Xf>& encoded);

  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const MapLayout> maps_;
  Eigen::Matrix3Xf sum_;
  std::vector<std::uint32_t> count_;  ///< of images in the sum
};

}  // namespace sheen
