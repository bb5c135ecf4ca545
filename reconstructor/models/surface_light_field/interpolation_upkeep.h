// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "reconstructor/models/surface_light_field/reflection_drift.h"
#include "reconstructor/models/surface_light_field/ring_model.h"
#include "reconstructor/models/surface_light_field/view_interpolation.h"

namespace sheen {

/// Keeps up to date how the rings of a light field interpolate between their views: the reflection that they share and
/// each ring's kernel. A little with every image, by the number of images alone, so that none costs much more than
/// another and the same images give the same bits.
class InterpolationUpkeep {
 public:
  using Rings = std::vector<std::unique_ptr<RingModel>>;  ///< per vertex; null where no image reached it
  /// `frames`: of the vertices' hemispheres.
  using Frames = std::span<const Eigen::Matrix3f>;

  InterpolationUpkeep(const Mesh& mesh, const ViewInterpolationOptions& options)
      : options_(options), choice_(mesh, options) {}

  /// After the `images`th image: `due` are the rings that want to choose their kernels.
  void after_image(std::size_t images, std::span<const std::uint32_t> due, Frames frames, Rings& rings);
  /// All again, after an image was taken out: a bad one makes smooth kernels look good everywhere.
  void rebuild(std::size_t images, Frames frames, Rings& rings);

 private:
  bool gather_levels(std::size_t most, Frames frames, const Rings& rings);
  void fit_reflection_now(Frames frames, Rings& rings);
  void advance_reflection(std::size_t images, Frames frames, Rings& rings);
  void adopt(Rings& rings);
  void choose(std::span<const std::uint32_t> undecided, Frames frames, Rings& rings);

  ViewInterpolationOptions options_;
  InterpolationChoice choice_;
  std::shared_ptr<const ReflectionDrift> reflection_;
  // The next fit, while it is under way: the levels that are gathered, and then the rounds.
  std::vector<RingLevels> levels_;
  std::optional<ReflectionFit> fit_;
  std::size_t fitted_at_ = 0;  ///< images ingested
};

}  // namespace sheen
