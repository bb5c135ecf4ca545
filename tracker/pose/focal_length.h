// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/camera/camera.h"
#include "common/capture/capture.h"
#include "common/stage/stage_layout.h"

namespace sheen {

/// How much longer the focal length of one image is than the camera's, as a fraction of it, and how uncertain that is.
struct FocalDeviation {
  double fraction = 0;
  double sigma = 0;  ///< large where the image hardly tells: a stage seen straight from above
};

/// From the tags that an image's pose rests on, with the pose solved anew for it. Empty where they do not determine it.
std::optional<FocalDeviation> focal_deviation(const Camera& camera, const StageLayout& stage,
                                              const std::vector<TagObservation>& tags, const Rigid3& pose);

/// Whether the lens is as it was calibrated, from the images of a run: with autofocus the focal length breathes.
class FocalWatch {
 public:
  void add(const FocalDeviation& deviation);

  std::uint64_t images() const { return images_; }
  double mean() const;    ///< of the images, weighted by what they tell; a fraction
  double sigma() const;   ///< of the mean, from what the images differ by where that is more than they state
  double spread() const;  ///< from image to image, beyond what each is uncertain by
  /// What a person should know, a sentence with what to do; empty: nothing is wrong, or too little is known.
  std::string finding() const;

 private:
  double excess() const;  ///< the images' differences over what they state: chi squared for each degree of freedom

  std::uint64_t images_ = 0;
  double weights_ = 0, sum_ = 0, squares_ = 0;
};

}  // namespace sheen
