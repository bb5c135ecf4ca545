// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "reconstructor/models/appearance_model.h"
#include "reconstructor/models/surface_light_field/constant_colour.h"
#include "reconstructor/models/surface_light_field/snapshot.h"
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"

namespace sheen {

/// The online surface light field (000): one online SVD a vertex ring, fed image by image.
class SurfaceLightField : public AppearanceModel {
 public:
  /// Throws ConfigError when an option is out of range, naming it.
  /// `scene`: of the mesh, where there is one already; it is made once.
  SurfaceLightField(std::shared_ptr<const Mesh> mesh, const SurfaceLightFieldOptions& options,
                    std::shared_ptr<const RayScene> scene = nullptr);
  ~SurfaceLightField() override;

  IngestReport ingest(const Capture& capture) override;
  /// Takes out again an image that was folded in, at the cost of folding one in. Nearly as if it had never been there:
  /// what it left in others (samples that were imputed with its help, exposures estimated with it) stays, and for the
  /// last bit the model is made anew. False when that is the only way: it is the first image, which the size of the
  /// maps and the level of exposure come from, or not one that was folded in.
  bool withdraw(const Capture& capture);
  bool began_with(const Capture& capture) const;  ///< the first image that showed something
  /// Whether anything was taken of an image: not of one that shows what an earlier one does.
  bool folded(const Capture& capture) const;
  /// Forgets all images, as if it were new; snapshots count on. With other options: as if it were made with these.
  void restart();
  void restart(const SurfaceLightFieldOptions& options);
  /// The same, but for what the first image that showed something has decided, whether it comes again or not.
  void fold_anew(const SurfaceLightFieldOptions& options);
  const SurfaceLightFieldOptions& options() const;

  /// Of the rings that an image shows, how many are updated, in (0, 1]: those for which its direction is newest. Holds
  /// for the images to come. The model is a function of the images and of the share at each.
  void set_share(double share);
  /// Lets go of terms beyond lower limits, in all rings at once: frees memory. They hold from now on.
  void limit_terms(int max_rank, int internal_rank, int block);
  std::shared_ptr<const ModelSnapshot> snapshot() override { return light_field_snapshot(); }
  std::shared_ptr<const SurfaceLightFieldSnapshot> light_field_snapshot();
  /// The mean colour of each surface sample over all images: what a model without view dependence would be.
  std::shared_ptr<const ModelSnapshot> constant_colour() const;

  std::size_t images() const;                       ///< folded in
  std::vector<std::size_t> rank_histogram() const;  ///< [rings of rank 0, 1, ...], rings that no image reached left out
  std::size_t bytes() const;                        ///< of all rings
  std::size_t snapshot_bytes() const;               ///< of a snapshot of all rings
  const VertexRings* rings() const;                 ///< null until an image comes
  double bytes_per_ring() const;                    ///< mean over rings that an image reached

 private:
  struct Pipeline;
  std::unique_ptr<Pipeline> pipeline_;
};

}  // namespace sheen
