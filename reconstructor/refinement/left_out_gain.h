// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"
#include "reconstructor/refinement/grey_pyramid.h"
#include "reconstructor/refinement/refinement_images.h"

namespace sheen {

inline constexpr double kWorthwhile_db = 0.1;  ///< less is what reflections and noise gain on what is right

/// Which images judge a refinement, and which it is made of: numbers of its images.
struct LeftOut {
  std::vector<std::size_t> left_out, others;
};
/// Every eighth is left out, of fewer than 32 every fourth.
LeftOut leave_out_some(std::size_t images);

/// An image that others are predicted from.
struct SourceImage {
  std::size_t number;  ///< of the refinement's images
  GreyPyramid image;
  PosedCamera view;
  Eigen::Vector3f eye = camera_centre(view.camera_from_object).cast<float>();

  /// The same image, taken from elsewhere.
  SourceImage moved_to(const Rigid3& camera_from_object) const {
    return {number, image, {view.camera, camera_from_object}};
  }
};
/// The four of `among` that see the object, of which this is the centre, from the sides nearest to that of a view.
std::vector<SourceImage> nearest_sources(const RefinementImages& images, const PosedCamera& view,
                                         const Eigen::Vector3d& centre, const std::vector<std::size_t>& among);

/// What predicts an image: a surface, from where the image was taken, and the images to predict it from.
struct ImagePrediction {
  const RayScene& scene;
  PosedCamera view;
  std::span<const SourceImage> sources;
};

/// By how much one prediction of an image is better than another, dB, in encoded luminance; empty where no pixel can be
/// judged. Each pixel `inside` is predicted from the sources that see the place (unstructured lumigraph, Buehler et al.
/// 2001); black where the surface shows nothing of a mask; without one the pixel may be of the background, and what it
/// is off by is taken to lie between what right and wrong surfaces are off by. `inside`: distance of each pixel from
/// the object's outline, pixels, above 0 in it.
std::optional<double> gain_at(const Capture& capture, const ImageF& inside, const ImagePrediction& before,
                              const ImagePrediction& after);

/// How well images that were left out of a refinement are predicted from the others, before and after it.
struct LeftOutGain {
  std::size_t images = 0;     ///< that were left out and could be judged
  double gain_db = 0;         ///< mean over them
  double standard_error = 0;  ///< of `gain_db`, dB
  /// A gain that is not chance and worth a change.
  bool refined_is_better() const { return images > 0 && gain_db > std::max(standard_error, kWorthwhile_db); }
};
/// `gain`: of one of the images, as of `gain_at`.
LeftOutGain mean_gain(const std::vector<std::size_t>& left_out,
                      const std::function<std::optional<double>(std::size_t image)>& gain,
                      const StepsDone& progress = {});

}  // namespace sheen
