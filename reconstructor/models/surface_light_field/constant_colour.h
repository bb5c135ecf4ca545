// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
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
/// dependence. Every figure of a surface light field stands beside it. A mean is kept in 16 bits: what rounding adds up
/// to over n images is about a sixth of n^(1/2) steps, and a step is 1/65536 where nothing is brighter than white.
class ConstantColour {
 public:
  ConstantColour(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const MapLayout> maps);

  /// Log of how much brighter an image is than the mean, per triangle that both show; NaN elsewhere.
  std::vector<float> log_ratios(const SurfaceImage& image) const;
  void add(const SurfaceImage& image);
  /// What an image showed of a patch. Different patches may be added and removed at the same time.
  void add(const PatchShape& patch, const PatchColumn& column);
  void remove(const PatchShape& patch, const PatchColumn& column);
  /// Means stand on these maps from now on.
  void use(std::shared_ptr<const MapLayout> maps);

  const std::shared_ptr<const Mesh>& shared_mesh() const { return mesh_; }
  const MapLayout& maps() const { return *maps_; }
  bool seen(std::size_t triangle, int sample) const {
    return !samples_[triangle].empty() && samples_[triangle][static_cast<std::size_t>(sample)].images > 0;
  }
  /// Encoded, of a sample that was seen.
  Eigen::Vector3f colour(std::size_t triangle, int sample) const;

 private:
  struct Sample {
    std::uint16_t code[3] = {};
    std::uint16_t images = 0;  ///< in the mean; no more are counted than it can hold
  };

  float scale(std::size_t triangle) const;
  static std::vector<Sample> carried(std::span<const Sample> from, int side, int to_side);
  /// Codes of brighter colours, where there is one.
  void make_room(std::size_t triangle, float brightest);
  void add(std::size_t triangle, std::span<const std::uint8_t> visible,
           const Eigen::Map<const Eigen::Matrix3Xf>& encoded);

  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const MapLayout> maps_;
  std::vector<std::vector<Sample>> samples_;  ///< per triangle; empty where no image showed it
  std::vector<std::int8_t> exponent_;         ///< per triangle: codes are of 2^exponent
};

/// The means as a picture has them, which must stay as they are: they are not copied.
std::shared_ptr<const Appearance> appearance_of(std::shared_ptr<const ConstantColour> means,
                                                ExposureField exposure = {});

}  // namespace sheen
