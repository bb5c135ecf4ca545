// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "common/capture/capture.h"

namespace sheen {

struct DetectorOptions {
  float quad_decimate = 2;  ///< quads are found at 1/2 size: a quarter of the time, no tag lost; edges are refitted
  int threads = 1;
  int max_hamming = 1;  ///< corrected bits; two would let one picture in some thousands show a tag that is not there
};

/// Grey image to find tags in. Bayer stays a mosaic (demosaicing would blur edges) with one gain per colour site, from
/// the bright, unsaturated quads (a stage is white paper), so that white is one level on every site.
ImageU8 detection_image(const RawImage& image);

/// Finds tag36h11 tags. Corners come in the order of `StageTag::corners_object` (seen upright: top left, top right,
/// bottom right, bottom left), in pixels with integer coordinates at pixel centres, to about 0.1 px.
class TagDetector {
 public:
  explicit TagDetector(const DetectorOptions& options = {});
  ~TagDetector();
  TagDetector(TagDetector&&) noexcept;

  std::vector<TagObservation> detect(const ImageU8& grey);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
