// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/folded_images.h"

#include <algorithm>

namespace sheen {

ImageName name_of(const Capture& capture) {
  return {capture.source_session, capture.sequence};
}

const FoldedImage* FoldedImages::find(const ImageName& name) const {
  const auto found = std::find_if(images_.begin(), images_.end(), [&](const FoldedImage& f) { return f.name == name; });
  return found == images_.end() ? nullptr : &*found;
}

void FoldedImages::erase(const ImageName& name) {
  images_.erase(std::find_if(images_.begin(), images_.end(), [&](const FoldedImage& f) { return f.name == name; }));
}

bool FoldedImages::any_nearer(const Eigen::Vector3d& eye, double distance) const {
  return std::any_of(images_.begin(), images_.end(),
                     [&](const FoldedImage& f) { return (f.eye - eye).norm() < distance; });
}

std::vector<PosedCamera> FoldedImages::cameras() const {
  std::vector<PosedCamera> cameras;
  for (const FoldedImage& image : images_) cameras.push_back(image.camera);
  return cameras;
}

ExposureField FoldedImages::exposure_field(const Eigen::Vector3f& centre) const {
  std::vector<Eigen::Vector3d> eyes;
  std::vector<float> log_gains;
  for (const FoldedImage& image : images_) {
    eyes.push_back(image.eye);
    log_gains.push_back(image.log_gain);
  }
  return interpolated_exposure(centre, eyes, log_gains);
}

}  // namespace sheen
