// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "common/capture/capture.h"
#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {

/// A light field made by formula, with no capture behind it: a bumpy ring with patterns, as bright as the direction
/// says. Patches of differing rank show the same, so that there are no seams between them.
struct SyntheticOptions {
  int around = 64, across = 24;  ///< 2 * around * across triangles
  int max_rank = 6;              ///< ranks differ from patch to patch: 1 .. max_rank
  double unseen = 0.1;  ///< fraction of the way round that no image has reached; behind it lies a part that is guessed,
                        ///< opposite one that is imputed
  std::uint64_t version = 1;
  std::vector<ShapeEvidence> evidence = {};  ///< the one of all vertices; empty: the mesh was given
};

class SyntheticLightField {
 public:
  explicit SyntheticLightField(const SyntheticOptions& options);

  std::shared_ptr<const SurfaceLightFieldSnapshot> snapshot() const { return snapshot_; }
  /// The next snapshot: every `stride`-th patch has new, brighter maps of another rank, all others are
  /// shared.
  std::shared_ptr<const SurfaceLightFieldSnapshot> with_changed_patches(int stride, int max_rank) const;
  /// The same light field in other bases: the terms of every patch in reverse order, every other one negated.
  std::shared_ptr<const SurfaceLightFieldSnapshot> with_other_bases() const;
  /// That, and every `stride`-th patch on maps with twice the intervals, which draw the same; not those of which some
  /// samples are known in other ways than others.
  std::shared_ptr<const SurfaceLightFieldSnapshot> with_finer_maps(std::uint32_t stride) const;
  /// The same light field, as much brighter from everywhere.
  std::shared_ptr<const SurfaceLightFieldSnapshot> with_exposure(float factor) const;

 private:
  std::shared_ptr<const PatchSnapshot> make_patch(std::size_t index, int rank, float brightness = 1) const;
  void in_planes(SurfacePatch& patch, const PatchShape& shape) const;
  VertexInterpolant make_vertex(std::uint32_t vertex, int rank) const;

  SyntheticOptions options_;
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const MapLayout> maps_;
  std::shared_ptr<const PatchShapes> shapes_;
  std::vector<Eigen::Vector3f> normals_;
  std::shared_ptr<const SurfaceLightFieldSnapshot> snapshot_;
};

/// A camera image of 640x480 with a pose on the object, two tags and lens distortion.
std::shared_ptr<const Capture> synthetic_capture(const Eigen::Vector3d& eye);

}  // namespace sheen
