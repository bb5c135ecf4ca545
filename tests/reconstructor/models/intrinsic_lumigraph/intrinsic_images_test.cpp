// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "reconstructor/lumigraph_file/shadow_hull.h"
#include "reconstructor/models/intrinsic_lumigraph/carved_hull.h"
#include "reconstructor/models/intrinsic_lumigraph/decomposition.h"
#include "reconstructor/models/intrinsic_lumigraph/predicted_arrival.h"
#include "reconstructor/models/intrinsic_lumigraph/shadow_masks.h"
#include "reconstructor/models/intrinsic_lumigraph/weiss.h"
#include "reconstructor/radiance/radiance_image.h"
#include "tests/reconstructor/models/intrinsic_lumigraph/small_rig.h"

namespace sheen {
namespace {

float albedo(int x, int y, int c) {
  return (x / 9 + y / 7) % 2 == 0 ? 0.7f - 0.1f * static_cast<float>(c) : 0.25f + 0.1f * static_cast<float>(c);
}

/// Shadows with edges in different places are no part of what all images have in common.
TEST(ReflectanceTest, ShadowsThatMoveAreLeftOut) {
  constexpr int kWidth = 51, kHeight = 40;  // odd: the transform is of even size
  std::vector<ImageF> images;
  for (int n = 0; n < 5; ++n) {
    ImageF& image = images.emplace_back(kWidth, kHeight, 3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        for (int c = 0; c < 3; ++c)
          image.at(x, y, c) = albedo(x, y, c) * (x > 8 * n + 3 && x < 8 * n + 9 ? 0.2f : 1.0f);
  }
  const ImageF reflectance = estimate_reflectance(images);
  for (int c = 0; c < 3; ++c) {
    const float scale = reflectance.at(0, 0, c) / albedo(0, 0, c);
    EXPECT_NEAR(scale, 1, 0.02);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        EXPECT_NEAR(reflectance.at(x, y, c) / albedo(x, y, c), scale, 0.02) << x << ", " << y;
  }
}

TEST(OtsuTest, SeparatesTwoClassesOfAnySize) {
  ImageF values(100, 10, 1);
  for (int i = 0; i < 1000; ++i) values.data()[i] = (i < 60 ? -2.0f : 0.5f) + 0.3f * std::sin(static_cast<float>(i));
  const float threshold = otsu_threshold(values, {});
  EXPECT_GT(threshold, -1.75f);
  EXPECT_LT(threshold, 0.25f);
  ImageU8 upper(100, 10, 1, 255);
  std::fill_n(upper.data(), 60, std::uint8_t{0});
  EXPECT_GT(otsu_threshold(values, upper), 0.1f) << "of one class alone";
  EXPECT_EQ(otsu_threshold(ImageF(4, 4, 1, 2.0f), {}), 2.0f);
}

/// Of a rig's true depth.
class ShadowTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    rig_ = new LightRig({.lights = 7, .columns = 1, .rows = 1, .width = 320, .height = 240});
    view_ = new CapturedView{.from = rig_->central_camera()};
    lights_ = new LightSet{.kind = LightKind::kPoint, .places = Eigen::Matrix3Xd(3, 7)};
    shadows_ = new std::vector<ImageU8>;
    for (int l = 0; l < 7; ++l) {
      const SimulatedPicture picture = rig_->picture(view_->from, rig_->lights()[l]);
      lights_->places.col(l) = rig_->lights()[l].position;
      view_->lights.push_back(l);
      view_->radiance.push_back(picture.radiance);
      view_->depth = picture.depth;
      shadows_->push_back(picture.shadow);
    }
  }
  static void TearDownTestSuite() {
    delete rig_;
    delete view_;
    delete lights_;
    delete shadows_;
  }
  static double iou(const ImageU8& arrives, const ImageU8& shadow) {
    std::size_t both = 0, either = 0;
    for (std::size_t i = 0; i < shadow.size(); ++i) {
      both += arrives.data()[i] < 128 && shadow.data()[i] != 0;
      either += arrives.data()[i] < 128 || shadow.data()[i] != 0;
    }
    return static_cast<double>(both) / static_cast<double>(either);
  }

  static inline LightRig* rig_;
  static inline CapturedView* view_;
  static inline LightSet* lights_;
  static inline std::vector<ImageU8>* shadows_;
};

TEST_F(ShadowTest, MasksOfImagesAreTheTruth) {
  const std::vector<ImageU8> masks = shadow_masks(*view_, *lights_);
  ASSERT_EQ(masks.size(), 7u);
  for (std::size_t l = 0; l < masks.size(); ++l) EXPECT_GT(iou(masks[l], (*shadows_)[l]), 0.8) << l;
}

TEST_F(ShadowTest, PixelsAtTheEdgeOfAShadowAreLitInPart) {
  const ImageU8 mask = shadow_masks(*view_, *lights_)[3];
  std::size_t between = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) between += mask.data()[i] > 60 && mask.data()[i] < 195;
  EXPECT_GT(between, 50u) << "pixels that a shadow's edge crosses";
  EXPECT_LT(between, mask.size() / 50);
}

/// The hull of true masks, but for what is done to them first.
class HullTest : public ShadowTest {
 protected:
  HullTest() : view_now_(*view_) {
    view_now_.arrives = *shadows_;
    for (ImageU8& mask : view_now_.arrives)
      for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = mask.data()[i] ? 0 : 255;
  }
  IntrinsicView decomposed() const {
    return decompose(view_now_, *lights_, estimate_reflectance(view_now_.radiance), 0.2);
  }
  /// Least over lights between.
  double agreement() const {
    const IntrinsicView lit = decomposed();
    const std::vector<const IntrinsicView*> views{&lit};
    const ShadowHull hull = carved_hull(views, *lights_);
    double least = 1;
    for (const std::size_t m : {1u, 2u, 3u}) {
      const LightState& light = rig_->midway_lights()[m];
      const ImageU8 truth = rig_->picture(view_->from, light).shadow;
      least = std::min(least, iou(reached_past(hull, lit, lights_->lamp(light.position)), truth));
    }
    return least;
  }
  CapturedView view_now_;
};

TEST_F(HullTest, CastsTheShadowsOfLightsBetween) {
  EXPECT_GT(agreement(), 0.8);
}

TEST_F(HullTest, DepthThatIsOffCastsNoSpecks) {
  std::mt19937 random(5);
  std::normal_distribution<float> millimetres(0, 0.0015f);
  for (std::size_t i = 0; i < view_now_.depth.size(); ++i)
    if (view_now_.depth.data()[i] > 0) view_now_.depth.data()[i] += millimetres(random);
  EXPECT_GT(agreement(), 0.75);
}

TEST_F(HullTest, HidesNothingOutsideItsGrid) {
  const IntrinsicView lit = decomposed();
  const std::vector<const IntrinsicView*> views{&lit};
  const Lamp lamp = lights_->lamp(0);
  EXPECT_FALSE(carved_hull(views, *lights_).hides({0, 0, 5}, lamp));
  EXPECT_FALSE(ShadowHull().hides({0, 0, 0}, lamp));
}

}  // namespace
}  // namespace sheen
