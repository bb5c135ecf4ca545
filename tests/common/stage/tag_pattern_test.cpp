// SPDX-License-Identifier: Apache-2.0
#include "common/stage/tag_pattern.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "common/base/errors.h"

namespace sheen {
namespace {

TEST(TagPattern, TheDetectorReadsEveryThirtiethIdUpright) {
  constexpr int kCellPx = 12, kSide = (kTagCells + 4) * kCellPx;  // two white cells round it
  const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(tag36h11_create(), tag36h11_destroy);
  const std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector(apriltag_detector_create(),
                                                                                      apriltag_detector_destroy);
  apriltag_detector_add_family(detector.get(), family.get());
  for (int id = 0; id < kTagIdCount; id += 30) {
    const TagPattern pattern = tag_pattern(id);
    std::vector<std::uint8_t> pixels(kSide * kSide);
    image_u8_t image{.width = kSide, .height = kSide, .stride = kSide, .buf = pixels.data()};
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const int column = x / kCellPx - 2, row = y / kCellPx - 2;
        const bool inside = column >= 0 && row >= 0 && column < kTagCells && row < kTagCells;
        pixels[y * kSide + x] = !inside || pattern.white[row][column] ? 240 : 20;
      }
    zarray_t* found = apriltag_detector_detect(detector.get(), &image);
    ASSERT_EQ(zarray_size(found), 1) << id;
    apriltag_detection_t* tag = nullptr;
    zarray_get(found, 0, &tag);
    EXPECT_EQ(tag->id, id);
    EXPECT_EQ(tag->hamming, 0);
    // The detector maps (-1, -1), the top left of an upright tag, through H.
    const auto h = [&](int r, int c) { return MATD_EL(tag->H, r, c); };
    const double w = -h(2, 0) - h(2, 1) + h(2, 2);
    EXPECT_NEAR((-h(0, 0) - h(0, 1) + h(0, 2)) / w, 2 * kCellPx, 1.5);
    EXPECT_NEAR((-h(1, 0) - h(1, 1) + h(1, 2)) / w, 2 * kCellPx, 1.5);
    apriltag_detections_destroy(found);
  }
}

TEST(TagPattern, RefusesIdsThatDoNotExist) {
  EXPECT_THROW(tag_pattern(-1), ConfigError);
  EXPECT_THROW(tag_pattern(kTagIdCount), ConfigError);
}

}  // namespace
}  // namespace sheen
