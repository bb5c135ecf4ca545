// SPDX-License-Identifier: Apache-2.0
#include "tracker/fiducials/tag_detector.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

namespace sheen {
namespace {

/// AprilTag 3.3.0 reports corners half a pixel to the lower right of where they are when pixel centres are integers.
constexpr double kCornerOffset = 0.5;

struct DetectionsDeleter {
  void operator()(zarray_t* detections) const { apriltag_detections_destroy(detections); }
};

}  // namespace

struct TagDetector::Impl {
  apriltag_family_t* family = tag36h11_create();
  apriltag_detector_t* detector = apriltag_detector_create();
  int max_hamming;

  explicit Impl(const DetectorOptions& options) : max_hamming(options.max_hamming) {
    detector->quad_decimate = options.quad_decimate;
    detector->nthreads = options.threads;
    apriltag_detector_add_family_bits(detector, family, max_hamming);
  }
  ~Impl() {
    apriltag_detector_destroy(detector);
    tag36h11_destroy(family);
  }
};

TagDetector::TagDetector(const DetectorOptions& options) : impl_(std::make_unique<Impl>(options)) {}
TagDetector::~TagDetector() = default;
TagDetector::TagDetector(TagDetector&&) noexcept = default;

std::vector<TagObservation> TagDetector::detect(const ImageU8& grey) {
  // The library does not write to the image, only its type cannot say so.
  image_u8_t view = {.width = grey.width(),
                     .height = grey.height(),
                     .stride = grey.width(),
                     .buf = const_cast<std::uint8_t*>(grey.data())};
  const std::unique_ptr<zarray_t, DetectionsDeleter> found(apriltag_detector_detect(impl_->detector, &view));
  std::vector<TagObservation> tags;
  for (int i = 0; i < zarray_size(found.get()); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(found.get(), i, &detection);
    TagObservation tag{.id = detection->id};
    // The library lists bottom left, bottom right, top right, top left.
    for (int corner = 0; corner < 4; ++corner) {
      const double* p = detection->p[3 - corner];
      tag.corners[corner] = Eigen::Vector2d(p[0] - kCornerOffset, p[1] - kCornerOffset);
    }
    tags.push_back(tag);
  }
  return tags;
}

}  // namespace sheen
