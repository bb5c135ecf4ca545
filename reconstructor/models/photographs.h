// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/capture/capture.h"
#include "common/image/image.h"
#include "reconstructor/models/appearance_model.h"
#include "reconstructor/surface/sample_visibility.h"

namespace sheen {

/// A photograph as image-based rendering keeps it, cut to what it shows of the object.
struct Photograph {
  Camera camera;
  Rigid3 camera_from_object;
  Eigen::Vector3d eye;  ///< object frame
  int left = 0, top = 0;
  ImageU8 pixels;     ///< sRGB
  ImageF depth;       ///< z of the surface; 0 where it is not safely seen (silhouettes, depth steps, mask)
  ImageU8 from_edge;  ///< as SurfaceView says
};

/// Edges are filled as the light field's are. `linear`: RGB. `view`: of this capture. Nothing where it shows the
/// surface nowhere safely.
std::optional<Photograph> cut_out(const Capture& capture, const ImageF& linear, const SurfaceView& view);

/// Cuts photographs of a mesh.
class PhotographCutter {
 public:
  explicit PhotographCutter(const Mesh& mesh);

  /// At the level of a model than which the capture is brighter by `gain`.
  std::optional<Photograph> cut(const Capture& capture, float gain);

 private:
  MapLayout corners_;
  SampleVisibility visibility_;
};

/// The photographs a model was built from, all kept: what image-based rendering needs, and what a surface light field
/// is measured against.
class PhotographSet {
 public:
  PhotographSet(std::shared_ptr<const Mesh> mesh, const VisibilityOptions& options)
      : mesh_(std::move(mesh)), options_(options) {}

  /// The same photographs with other pixels.
  PhotographSet(const PhotographSet& other, std::vector<Photograph> photographs)
      : mesh_(other.mesh_), options_(other.options_), photographs_(std::move(photographs)) {}

  /// Arguments as of `cut_out`.
  void add(const Capture& capture, const ImageF& linear, const SurfaceView& view);
  std::size_t size() const { return photographs_.size(); }
  const std::vector<Photograph>& photographs() const { return photographs_; }
  std::size_t pixel_bytes() const;   ///< of the cut-outs, uncompressed
  std::size_t memory_bytes() const;  ///< with what blending needs beside

  /// Each point takes its colour from the photograph that shows it from the direction nearest to the eye's.
  /// `where_unseen` shades the points that no photograph shows.
  static std::shared_ptr<const Appearance> nearest_photograph(std::shared_ptr<const PhotographSet> photographs,
                                                              std::shared_ptr<const Appearance> where_unseen);

  /// Unstructured lumigraph (Buehler et al. 2001, sec. 4.2): the four photographs with the least angle a_j between
  /// their ray and the eye's, weighted by (1 - a_j / a_5) / a_j, a_5 being the next one's angle, so that a photograph
  /// fades out before it is exchanged and one taken from the eye is shown as it is. Encoded values are blended.
  static std::shared_ptr<const Appearance> unstructured_lumigraph(std::shared_ptr<const PhotographSet> photographs,
                                                                  std::shared_ptr<const Appearance> where_unseen);

  const Mesh& mesh() const { return *mesh_; }
  /// Weighted mean of up to `count` photographs' encoded colours at a surface point; weights sum to 1. False when no
  /// photograph shows the point.
  bool blend(std::uint32_t triangle, const Eigen::Vector3d& point, const Eigen::Vector3d& eye, int count,
             Eigen::Vector3f& encoded) const;

 private:
  std::shared_ptr<const Mesh> mesh_;
  VisibilityOptions options_;
  std::vector<Photograph> photographs_;
};

}  // namespace sheen
