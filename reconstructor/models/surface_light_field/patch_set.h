// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/capture/trade.h"
#include "reconstructor/light_field_file/patch_shapes.h"
#include "reconstructor/models/surface_light_field/constant_colour.h"
#include "reconstructor/models/surface_light_field/interpolation_upkeep.h"
#include "reconstructor/models/surface_light_field/patch_column.h"
#include "reconstructor/models/surface_light_field/patch_model.h"
#include "reconstructor/surface/map_layout.h"
#include "reconstructor/surface/sample_visibility.h"

namespace sheen {

/// Mean of a patch's triangles, by their areas.
SurfaceSite centre_of(const Mesh& mesh, const PatchShape& patch);

/// The patches of a light field and what images do to them. Patches do not depend on each other but by how their
/// vertices interpolate, so they are worked on in parallel; everything here depends on the images alone.
class PatchSet {
 public:
  using Indices = std::span<const std::uint32_t>;  ///< of patches, ascending

  /// `frames`: of the vertices' hemispheres; `pixels_per_metre`: of the image that the maps are made for.
  PatchSet(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const MapLayout> maps,
           std::span<const Eigen::Matrix3f> frames, const PatchModelOptions& options, double pixels_per_metre);

  const std::shared_ptr<const PatchShapes>& shapes() const { return shapes_; }
  bool reached(std::uint32_t patch) const { return models_[patch] != nullptr; }  ///< by an image that shows enough

  /// Patches of which an image shows something.
  std::vector<std::uint32_t> shown_by(const SurfaceView& view) const;
  /// Of these, so many: those for which the direction of the image is newest.
  std::vector<std::uint32_t> newest(Indices shown, const SurfaceView& view, std::size_t wanted) const;
  /// How many of these have seen what the image shows of them (PatchModel::repeats).
  std::size_t count_repeated(Indices tested, const SurfaceImage& image) const;
  /// How the patches, before they ingest the image, predict what it shows of them.
  PatchModel::Prediction predict(Indices asked, const SurfaceImage& image) const;

  struct Update {
    std::vector<std::uint8_t> repeated;  ///< for each patch: it was shown nothing new and took nothing
    std::size_t updated = 0;
    double energy = 0, residual_energy = 0;  ///< PatchModel::Absorbed, of all
  };
  /// The patches `chosen` ingest the image, the `images`th. Where most have seen what it shows, the few that use it
  /// fold it at once. `constant` takes all that the image shows.
  Update absorb(Indices chosen, const SurfaceImage& image, std::size_t images, ConstantColour& constant);
  /// The patches that ingested the image, all that it shows when `taken` is empty, remove it, and so does `constant`;
  /// `images` are left.
  void withdraw(const SurfaceImage& image, const std::vector<bool>& taken, std::size_t images,
                ConstantColour& constant);

  /// Of the patches that are due to be asked (PatchModel::maps_due), those whose maps are finer than what is displayed
  /// needs get coarser ones (PatchModel::sufficient_sides). The layout is null when none did.
  std::shared_ptr<const MapLayout> coarsen_maps(Indices asked, double detail, double error);
  /// All patches are due to be asked, and have folded the images that wait.
  void settle_maps();
  /// Patches that an image of so many pixels per metre shows finer than the images before it get maps of these sides,
  /// where they are larger. `sides`: per triangle. The layout is null when none did.
  std::shared_ptr<const MapLayout> refine_maps(const SurfaceView& view, double pixels_per_metre, const MapSides& sides);
  /// Whether an image may show a patch that much finer.
  bool may_refine(double pixels_per_metre) const;

  /// In all patches at once.
  void limit(const PatchLimit& limit);
  std::vector<std::shared_ptr<const PatchSnapshot>> snapshots();
  /// The same for the last time: each patch is let go of when its snapshot is there.
  std::vector<std::shared_ptr<const PatchSnapshot>> finish();

  std::size_t size() const { return models_.size(); }
  std::size_t bytes() const;
  std::size_t snapshot_bytes() const;
  /// [patches of rank 0, 1, ...], patches that no image reached left out.
  std::vector<std::size_t> rank_histogram() const;
  /// Energy of all patches, orthogonality of a few dozen, evenly spread.
  NumericalHealth health() const;

 private:
  struct NewSides {
    std::uint32_t patch;
    MapSides sides;
  };
  /// `filter`: per triangle (MapLayout::filter_resolution).
  std::shared_ptr<const MapLayout> lay_out(const std::vector<NewSides>& changed, MapSides filter);
  MapSides filter_sides() const;
  MapSides sides_of(std::uint32_t patch) const;
  void add_left_out(Indices chosen, const SurfaceImage& image, ConstantColour& constant) const;
  bool is_latest(std::uint32_t patch) const;
  InterpolatedVertex at_vertex(std::uint32_t vertex) const {
    return {mesh_->vertices[vertex], frames_[vertex], interpolation_.of(vertex)};
  }

  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const MapLayout> maps_;
  std::shared_ptr<const PatchShapes> shapes_;
  std::span<const Eigen::Matrix3f> frames_;
  PatchModelOptions options_;
  std::vector<SurfaceSite> centres_;  ///< per patch
  std::vector<std::unique_ptr<PatchModel>> models_;
  InterpolationUpkeep interpolation_;
  std::vector<float> pixels_per_metre_;  ///< per patch: of the finest image that its maps were made for
};

}  // namespace sheen
