// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "reconstructor/models/surface_light_field/ring_column.h"
#include "reconstructor/models/surface_light_field/ring_model.h"
#include "reconstructor/surface/ring_visibility.h"
#include "reconstructor/surface/vertex_ring.h"

namespace sheen {

/// What an image shows of the surface: where its samples lie, and their encoded values (`resample`).
struct ShownImage {
  const SurfaceView& view;
  const Eigen::Matrix3Xf& samples;
};

/// The rings of a light field, one for each vertex, and what images do to them. Rings do not depend on each other, so
/// they are worked on in parallel; everything here depends on the images alone.
class RingSet {
 public:
  using Indices = std::span<const std::uint32_t>;  ///< of rings, ascending

  /// `frames`: of the vertices' hemispheres.
  RingSet(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const VertexRings> rings,
          std::span<const Eigen::Matrix3f> frames, const RingModelOptions& options);

  std::vector<std::unique_ptr<RingModel>>& models() { return models_; }  ///< null until an image shows enough of it
  const std::vector<std::unique_ptr<RingModel>>& models() const { return models_; }

  /// Rings of which an image shows something.
  std::vector<std::uint32_t> shown_by(const SurfaceView& view) const;
  /// Of these, so many: those for which the direction of the image is newest.
  std::vector<std::uint32_t> newest(Indices shown, const SurfaceView& view, std::size_t wanted) const;
  /// How many of these have seen what the image shows of them (RingModel::repeats).
  std::size_t count_repeated(Indices tested, const ShownImage& image) const;
  /// How the rings, before they ingest the image, predict what it shows of them.
  RingModel::Prediction predict(Indices asked, const ShownImage& image) const;

  struct Update {
    std::vector<std::uint8_t> repeated;    ///< for each ring: it was shown nothing new and took nothing
    std::vector<std::uint32_t> undecided;  ///< rings that want to choose their interpolation again
    std::size_t updated = 0;
    double energy = 0, residual_energy = 0;  ///< RingModel::Absorbed, of all
  };
  /// The rings `chosen` ingest the image. Where most have seen what it shows, the few that use it fold it at once: no
  /// others would share the columns that wait.
  Update absorb(Indices chosen, const ShownImage& image);
  /// The rings that ingested the image, all that it shows when `taken` is empty, remove it.
  void withdraw(const ShownImage& image, const std::vector<bool>& taken);

  /// In all rings at once.
  void limit_terms(int max_rank, int internal_rank, int block);
  std::vector<std::shared_ptr<const RingSnapshot>> snapshots();
  /// The same for the last time: each ring is let go of when its snapshot is there.
  std::vector<std::shared_ptr<const RingSnapshot>> finish();

  std::size_t bytes() const;
  std::size_t snapshot_bytes() const;
  /// [rings of rank 0, 1, ...], rings that no image reached left out.
  std::vector<std::size_t> rank_histogram() const;

 private:
  std::shared_ptr<const RingSnapshot> snapshot(std::size_t ring);
  bool gather(std::size_t ring, const ShownImage& image, RingColumn& column) const;

  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const VertexRings> rings_;
  std::span<const Eigen::Matrix3f> frames_;
  RingModelOptions options_;
  std::vector<unsigned> phases_;  ///< per ring: when it folds
  std::vector<std::unique_ptr<RingModel>> models_;
};

}  // namespace sheen
