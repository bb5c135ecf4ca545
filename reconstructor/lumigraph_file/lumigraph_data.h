// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "common/parallel/for_each.h"
#include "reconstructor/lumigraph_file/intrinsic_view.h"
#include "reconstructor/lumigraph_file/shadow_hull.h"

namespace sheen {

/// All that an intrinsic lumigraph knows.
struct LumigraphData {
  LightSet lights;
  std::vector<std::shared_ptr<const IntrinsicView>> views;
  bool of_images = false;  ///< there is no mesh: depth is by stereo, visibility by the hull
  ShadowHull hull;         ///< empty where there is a mesh
  double error =
      0.14;  ///< RMS of encoded values, 0..1, of predicting an image in a light that was left out; 0.14: a guess
};

/// Those of a view's lights between which a place of the set lies, and their weights (`LightSet::between`).
using LightWeights = std::vector<std::pair<std::size_t, float>>;
LightWeights lights_between(const IntrinsicView& view, const LightSet& lights, const Eigen::Vector3d& place);

/// Radiance of a view in a light where it arrives, and where it does not. RGB.
struct RelitView {
  ImageF lit, dark;
};
/// `place`: of the light, see `LightSet::place_of`. What a Lambertian surface does not explain is taken from the lights
/// between which it lies.
RelitView relight(const IntrinsicView& view, const LightSet& lights, const Eigen::Vector3d& place,
                  const ForEach& for_each);

/// The same of a matt surface that reflects all light: its illumination (001 sec. 4.3), all channels alike.
RelitView illuminated(const IntrinsicView& view, const LightSet& lights, const Eigen::Vector3d& place,
                      const ForEach& for_each);

/// Multiplies by the colour of a light.
void scale(RelitView& relit, const Eigen::Vector3f& rgb);

/// dark + V (lit - dark).
ImageF shadowed(const RelitView& relit, const ImageU8& arrives);

/// The picture of a view that linear interpolation of its images gives: what everything is compared with.
ImageF interpolated_images(const IntrinsicView& view, const LightSet& lights, const Eigen::Vector3d& place,
                           const ForEach& for_each);

/// The same of its visibility, 0..1 in three equal channels.
ImageF interpolated_visibility(const IntrinsicView& view, const LightSet& lights, const Eigen::Vector3d& place);

/// The mean of a view's images.
ImageF mean_image(const IntrinsicView& view, const LightSet& lights, const ForEach& for_each);

std::size_t bytes_of(const IntrinsicView& view);

/// A view to be blended and its weight; the weights sum to 1.
struct WeightedView {
  std::size_t view = 0;
  float weight = 1;
};
/// The views nearest to an eye, up to four; weights fall to zero at the distance of the next one (as Buehler et al.
/// 2001 do with angles). One view alone where the eye is at its place.
std::vector<WeightedView> views_near(const std::vector<std::shared_ptr<const IntrinsicView>>& views,
                                     const Eigen::Vector3d& eye);
/// The same, but where all views are about equally far, which is beyond them, and a small step of the eye would
/// exchange the nearest ones: it fades to a few views from all round, the same for all eyes.
std::vector<WeightedView> views_round(const std::vector<std::shared_ptr<const IntrinsicView>>& views,
                                      const Eigen::Vector3d& eye);

}  // namespace sheen
