// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"
#include "reconstructor/surface/map_layout.h"
#include "reconstructor/surface/pixel_rays.h"
#include "reconstructor/surface/sample_projection.h"

namespace sheen {

/// What decides whether an image shows a sample.
enum class VisibilityTest {
  kSamples,   ///< the sample itself
  kVertices,  ///< the paper's (000 sec. 4.2): all of a triangle is shown where its three vertices are
};

struct VisibilityOptions {
  VisibilityTest test = VisibilityTest::kSamples;
  int erosion_px = 0;       ///< kept away from edges (silhouettes, depth steps, the mask's and the image's border)
                            ///< beyond the pixels that touch one
  double min_cosine = 0.1;  ///< of the angle between a triangle's normal and the direction to the camera
  double depth_step = 8;    ///< a step between neighbouring pixels, in pixel footprints, that is an edge and no slope
  double depth_tolerance = 6;  ///< how far behind the first hit a sample may lie, in pixel footprints
};

/// What one image shows of the sampled surface. Arrays per sample run as MapLayout::first_sample says.
struct SurfaceView {
  Eigen::Vector3d eye;                   ///< object frame
  const SampleProjection* places;        ///< of the samples
  PixelBox box;                          ///< pixels that can show the mesh
  std::vector<std::uint8_t> visible;     ///< per sample
  std::vector<int> visible_in_triangle;  ///< per triangle: how many of its samples are visible
  std::vector<float> cosine;             ///< per triangle: towards the camera; <= 0 when it faces away
  std::vector<float> step_px;            ///< per triangle: what samples stand for in the image, across
  std::size_t visible_samples = 0;
  /// Per pixel of the image: z of the first hit in the camera's frame where it lies on a front face and safely inside a
  /// surface, away from every edge; else 0. Only there may anything be sampled.
  ImageF safe_depth;
  /// Per pixel of the image: whether it touches an edge, 0, or shows nothing but one surface: 1 beside pixels that
  /// touch one, else 2. Within two pixels of a 2 (one, of a 1) lies nothing but the same surface and its edge.
  ImageU8 from_edge;
};

/// Decides sample by sample what an image shows (000 sec. 4.2, which tests vertices only): the sample must be the first
/// hit of its pixel's ray on a front face, away from every silhouette and depth edge, so that background never bleeds
/// in. The paper's own test (`VisibilityTest::kVertices`) knows no edges: what hides the middle of a triangle, or lies
/// beside it in its pixels, is taken for its colour.
class SampleVisibility {
 public:
  /// `scene`: of the mesh, where there is one already.
  SampleVisibility(const Mesh& mesh, const MapLayout& maps, const VisibilityOptions& options,
                   std::shared_ptr<const RayScene> scene = nullptr);

  void use(const MapLayout& maps);  ///< others

  /// `mask`: empty, or the image's size with 0 where pixels are to be ignored. Not thread-safe (buffers are reused).
  const SurfaceView& look(const Camera& camera, const Rigid3& camera_from_object, const ImageU8& mask);

 private:
  /// z of the first hit; 0 where it is none or a back face; negative where masked.
  void cast_depth(const Camera& camera, const Rigid3& camera_from_object, const ImageU8& mask);
  /// Makes that safe.
  void erode_depth(const Camera& camera);
  /// Or takes it as it is.
  void ignore_edges();
  void find_facing();
  void test_samples(const Camera& camera);
  void test_vertices(const Camera& camera, const Rigid3& camera_from_object, const ImageU8& mask);
  /// Marks the samples of triangles that `may_show(t)` where `shows(column, row, z)` of the pixel and their depth.
  template <typename MayShow, typename Shows>
  void mark_samples(const Camera& camera, MayShow&& may_show, Shows&& shows);
  float nearer(const Camera& camera) const;  ///< fraction of a depth: what is nearer than that hides what is there

  const Mesh& mesh_;
  const MapLayout* maps_;
  VisibilityOptions options_;
  std::shared_ptr<const RayScene> scene_;
  SampleProjection projection_;
  PixelRays rays_;
  ImageU8 smooth_, narrow_;  ///< of `erode_depth`
  SurfaceView view_;
};

}  // namespace sheen
