// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/image/image.h"
#include "reconstructor/shape/stage_picture.h"

namespace sheen {

/// What a stage's sheet without an object would show in each pixel of a view.
struct SheetPrediction {
  std::vector<Eigen::Vector2f> point;  ///< of the plane of the sheet
  ImageF ink, least_ink, most_ink;     ///< share; within a pixel in each direction; NaN off the sheet
  std::vector<int> tag;                ///< -1: none
};

SheetPrediction predict(const StagePicture& sheet, const PosedCamera& camera);

/// The light on the sheet in a view, as its tags show it.
struct SheetLight {
  struct Tag {
    int number;
    Eigen::Vector2f place;
    Eigen::Array3f paper;  ///< linear RGB
  };
  std::vector<Tag> tags;   ///< those that look as they are printed
  std::vector<bool> seen;  ///< per tag of the stage
  Eigen::Array3f ink;      ///< of the paper beside it
  float tag_size = 0;

  /// Of paper at a place: the nearer a tag the more its light counts.
  Eigen::Array3f paper_at(const Eigen::Vector2f& place) const {
    Eigen::Array3f sum = Eigen::Array3f::Zero();
    float weights = 0;
    for (const Tag& tag : tags) {
      const float near = (place - tag.place).squaredNorm() / (tag_size * tag_size) + 0.1f;
      const float weight = 1 / (near * near);
      sum += weight * tag.paper;
      weights += weight;
    }
    return sum / weights;
  }
};

/// `colour`: linear RGB of the view that was predicted.
SheetLight fit_light(const StagePicture& sheet, const SheetPrediction& predicted, const ImageF& colour);

}  // namespace sheen
