// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/ray_scene.h"
#include "reconstructor/refinement/grey_pyramid.h"
#include "reconstructor/refinement/vertex_patches.h"

namespace sheen {

/// Places along its normal at which a vertex is tried: kSweepReach to either side, one patch spacing apart.
inline constexpr int kSweepReach = 4;
inline constexpr int kSweepPlaces = 2 * kSweepReach + 1;

/// What images showed of a vertex's patch in an earlier pass: less its mean, over its contrast.
struct ExpectedPatch {
  std::array<float, kPatchPoints> values{};
  float energy = 0;  ///< the images' mean squared distance from it; 0: nothing is expected
};

/// Which of two halves a view of a vertex belongs to.
struct ViewSplit {
  Eigen::Vector3f axis = Eigen::Vector3f::UnitX();  ///< tangent, unit
  float at = 0;
  int half(const Eigen::Vector3f& to_eye) const { return axis.dot(to_eye) > at ? 1 : 0; }
};
/// A split for each vertex: across the direction in which the cameras that it faces lie furthest apart, at their
/// median. What has a place of its own for each direction, as reflections have, looks alike to neighbouring views and
/// not to the two halves.
std::vector<ViewSplit> split_views(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals,
                                   std::span<const PosedCamera> cameras);

/// How well the images agree about each vertex's patch, at each place along the normal. Every view is in one of two
/// halves, whose disagreement tells how much an answer is worth.
/// An image that showed something else (a highlight, what hides the place) has a lower weight, by Cauchy's rule from
/// its distance to what an earlier pass expects.
///
/// p_i(k) is what image i shows of a patch at place k, less its mean, over its contrast. What is kept is the sums of
/// w, w |p|^2 and w p over images; the images' squared distance from their mean follows exactly:
///   E(k) = sum w |p|^2 - |sum w p|^2 / sum w.
/// So an image is looked at once, and the mean that it is compared with is that of the others but for the factor
/// (1 - w_i / sum w), which is the same at each place.
class NormalSweep {
 public:
  /// `splits`: per vertex; empty: images belong to the halves in turn. `clearance`: patch spacings between a patch and
  /// what a ray to it may meet. `expected`: per vertex, or empty.
  NormalSweep(const Mesh& mesh, const VertexPatches& patches, std::span<const ViewSplit> splits, double clearance,
              std::span<const ExpectedPatch> expected = {});

  /// `scene`: of the mesh.
  void add(const GreyPyramid& image, const PosedCamera& view, const RayScene& scene);

  using Energy = std::array<float, kSweepPlaces>;
  enum Part { kFirst = 0, kSecond = 1, kBoth = 2 };
  /// E of a vertex, per place; per sum of weights, so 0 (all alike) to 1.
  Energy energy(std::size_t vertex, Part part) const;
  /// Mean correlation of pairs of images with each other at a place, -1 to 1, patches without contrast counting as 0.
  float agreement(std::size_t vertex, int place) const;
  ExpectedPatch expected(std::size_t vertex, int place) const;
  int images(std::size_t vertex, Part part) const;
  std::size_t vertices() const { return mesh_.vertices.size(); }

 private:
  struct Sums {
    float weight = 0;
    int images = 0;
    std::array<float, kSweepPlaces> squares{};
    std::array<std::array<float, kPatchPoints>, kSweepPlaces> patch{};
  };
  const Mesh& mesh_;
  const VertexPatches& patches_;
  std::span<const ViewSplit> splits_;
  float clearance_;
  std::size_t images_ = 0;
  std::span<const ExpectedPatch> expected_;
  std::array<std::vector<Sums>, 2> halves_;
};

}  // namespace sheen
