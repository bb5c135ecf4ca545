// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "reconstructor/light_field_file/patch_shapes.h"
#include "reconstructor/models/surface_light_field/patch_model.h"
#include "reconstructor/models/surface_light_field/reflection_fit.h"
#include "reconstructor/models/surface_light_field/view_interpolation.h"

namespace sheen {

/// Keeps up to date how the vertices of a light field interpolate between views: the reflection that they share and
/// each vertex's kernel, from the patches' own views. A little with every image, by the number of images alone, so that
/// none costs much more than another and the same images give the same bits.
class InterpolationUpkeep {
 public:
  using Patches = std::span<const std::unique_ptr<PatchModel>>;  ///< null where no image reached it

  InterpolationUpkeep(std::shared_ptr<const PatchShapes> shapes, const ViewInterpolationOptions& options)
      : shapes_(std::move(shapes)), options_(options), choice_(shapes_, options), chosen_(choice_.vertices()) {}

  /// The same patches on other maps.
  void use(std::shared_ptr<const PatchShapes> shapes) {
    shapes_ = std::move(shapes);
    choice_.use(shapes_);
  }

  /// How a vertex now interpolates.
  SharedInterpolation of(std::uint32_t vertex) const { return {chosen_[vertex], reflection_}; }

  /// After the `images`th image: `due` are the patches that want to choose again.
  void after_image(std::size_t images, std::span<const std::uint32_t> due, Patches patches);
  /// All again, after an image was taken out: a bad one makes smooth kernels look good everywhere.
  void rebuild(std::size_t images, Patches patches);

 private:
  bool gather_levels(std::size_t most, Patches patches);
  void fit_reflection_now(Patches patches);
  void advance_reflection(std::size_t images, Patches patches);
  void adopt();
  void choose(std::span<const std::uint32_t> undecided, Patches patches);

  std::shared_ptr<const PatchShapes> shapes_;
  ViewInterpolationOptions options_;
  InterpolationChoice choice_;
  std::vector<ViewInterpolation> chosen_;  ///< per vertex
  std::shared_ptr<const ReflectionDrift> reflection_;
  // The next fit, while it is under way: the levels that are gathered, and then the rounds.
  std::vector<PatchLevels> levels_;
  std::optional<ReflectionFit> fit_;
  std::size_t fitted_at_ = 0;  ///< images ingested
};

}  // namespace sheen
