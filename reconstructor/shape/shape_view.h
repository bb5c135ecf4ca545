// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "common/camera/posed_camera.h"
#include "common/capture/capture.h"
#include "common/image/image.h"

namespace sheen {

/// What an image says of the outline of the object, pixel by pixel.
enum class Outline : std::uint8_t { kBackground = 0, kUnknown = 1, kObject = 2 };

/// A part of an image as a pinhole camera would have taken it at some scale: what a shape is found from.
struct ShapeView {
  std::string name;
  PosedCamera camera;  ///< without a lens, of the size of the part
  ImageF grey;         ///< encoded luminance, 0 to 255; NaN where the lens showed nothing or the value is of no use
  ImageU8 outline;     ///< `Outline`; empty where all is unknown
  bool before_sheet = false;  ///< the outline was found by the stage's sheet, which shows it in part
};

/// The camera that takes a part of what `camera` without its lens takes, at a scale. The part's sides are pixels of
/// that camera.
Camera camera_of_part(const Camera& camera, const PixelBox& part, double scale);

/// A view, and what only its outline is found from.
struct ColourView {
  ShapeView view;
  ImageF colour;  ///< linear RGB; NaN where the lens showed nothing
};

/// Reads the part at the scale, each pixel the mean of what it covers. The outline is that of the capture's mask;
/// without one it is empty.
ColourView colour_view(const Capture& capture, const PixelBox& part, double scale);

}  // namespace sheen
