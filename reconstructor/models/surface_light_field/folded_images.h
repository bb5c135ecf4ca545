// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/capture/capture.h"
#include "reconstructor/radiance/exposure_field.h"

namespace sheen {

/// What tells images apart: the source session and the number in it.
using ImageName = std::pair<std::string, std::uint64_t>;
ImageName name_of(const Capture& capture);

/// What a model stores of an image that it ingested, so that it can be taken out again.
struct FoldedImage {
  ImageName name;
  float gain;      ///< that its values were divided by
  float log_gain;  ///< estimated; 0 where the gain is known
  Eigen::Vector3d eye;
  PosedCamera camera;
  std::vector<bool> taken;  ///< for each patch, whether it used what the image shows; empty when all did
};

/// The images that were ingested, in their order.
class FoldedImages {
 public:
  std::size_t count() const { return images_.size(); }
  void add(FoldedImage image) { images_.push_back(std::move(image)); }
  const FoldedImage* find(const ImageName& name) const;  ///< null when it was not ingested
  void erase(const ImageName& name);
  std::vector<PosedCamera> cameras() const;
  bool any_nearer(const Eigen::Vector3d& eye, double distance) const;
  /// The estimated gains over the directions from `centre` to the eyes.
  ExposureField exposure_field(const Eigen::Vector3f& centre) const;

 private:
  std::vector<FoldedImage> images_;
};

}  // namespace sheen
