// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/evaluation/held_out.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/errors.h"
#include "common/image/color.h"
#include "common/image/exr.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/plain_model.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using testing::PlainModel;

const Rigid3 kPose = look_at({0.083, 0.021, 0.4}, {0.013, 0.007, 0}, {0.1, 1, 0});

Camera camera() {
  return {.width = 120, .height = 90, .fx = 150, .fy = 150, .cx = 59.5, .cy = 44.5};
}

/// Linear radiance that is shown as this grey level.
float level(int grey) {
  return srgb_decode(grey / 255.0f);
}

Capture uniform_capture(float radiance, const ImageU8& mask = {}) {
  Capture capture;
  capture.name = "view";
  capture.camera = camera();
  capture.image = analytic::float_image(ImageF(120, 90, 3, radiance));
  capture.mask = mask;
  capture.pose = {.status = PoseStatus::kGiven, .camera_from_object = kPose};
  return capture;
}

std::size_t count(const ImageU8& image) {
  return image.size() - static_cast<std::size_t>(std::count(image.data(), image.data() + image.size(), 0));
}

class HeldOut : public ::testing::Test {
 protected:
  const Mesh mesh = square_mesh(0.1f, 0, 4);
  const RayPainter painter{mesh};
  /// The square's pixels by closed form.
  ImageU8 silhouette() const {
    ImageU8 image(120, 90, 1);
    const Rigid3 object_from_camera = kPose.inverse();
    for (int y = 0; y < 90; ++y)
      for (int x = 0; x < 120; ++x)
        image.at(x, y) = analytic::square(0.1, 0)(object_from_camera.translation,
                                                  object_from_camera.rotation * *camera().ray({double(x), double(y)})) <
                                 analytic::kMiss
                             ? 255
                             : 0;
    return image;
  }
};

TEST_F(HeldOut, AKnownOffsetGivesItsClosedFormPsnr) {
  const PlainModel model(mesh, Eigen::Vector3f::Constant(level(120)));
  for (const int offset : {1, 4, 20, -7}) {
    const HeldOutView view = make_held_out_view(uniform_capture(level(120 + offset)), 1, painter);
    EXPECT_EQ(view.pixels().truth.at(5, 5, 1), 120 + offset);
    const ViewScore result = score(view, model, painter);
    EXPECT_NEAR(result.psnr_db, 20 * std::log10(255.0 / std::abs(offset)), 1e-9);
    EXPECT_EQ(result.error.count, 3 * count(view.pixels().object));
    EXPECT_EQ(result.name, "view");
  }
}

TEST_F(HeldOut, TheSamePictureIsPerfect) {
  const PlainModel model(mesh, Eigen::Vector3f::Constant(level(120)));
  Capture capture = uniform_capture(0);
  ImageF pixels(120, 90, 3);
  const ImageU8 inside = silhouette();
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels.data()[i] = inside.data()[i / 3] ? level(120) : 0;
  capture.image = analytic::float_image(pixels);
  const ViewScore same = score(make_held_out_view(capture, 1, painter), model, painter);
  EXPECT_EQ(same.psnr_db, std::numeric_limits<double>::infinity());
  EXPECT_EQ(same.full_psnr_db, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(same.ssim, 1, 1e-5);
  EXPECT_NEAR(same.full_ssim, 1, 1e-5);
}

TEST_F(HeldOut, TheFullPictureIsBlackWhereThereIsNoSurface) {
  const PlainModel model(mesh, Eigen::Vector3f::Constant(level(120)));
  const ViewScore result = score(make_held_out_view(uniform_capture(level(130)), 1, painter), model, painter);
  const double inside = static_cast<double>(count(silhouette())), outside = 120 * 90 - inside;
  const double mean_square = (inside * 10 * 10 + outside * 130 * 130) / (120 * 90);
  EXPECT_NEAR(result.full_psnr_db, 10 * std::log10(255 * 255 / mean_square), 1e-9);
  EXPECT_LT(result.full_ssim, result.ssim);
}

TEST_F(HeldOut, GainAlignmentUndoesAGain) {
  PlainModel model(mesh);
  model.shows_place = true;  // colours from 0 to 0.1, those below 0 are cut off by both
  ImageF truth = painter.paint(model, camera(), kPose).beauty;
  for (const float gain : {0.5f, 1.0f, 1.7f, 3.0f}) {
    ImageF brightened = truth;
    for (std::size_t i = 0; i < truth.size(); ++i) brightened.data()[i] *= gain;
    Capture capture = uniform_capture(0);
    capture.image = analytic::float_image(brightened);
    const ViewScore result = score(make_held_out_view(capture, 1, painter), model, painter);
    EXPECT_GT(result.psnr_gain_aligned_db, 55) << gain;
    if (gain != 1) EXPECT_LT(result.psnr_db, 30);
    // The camera's own word on the gain does the same.
    EXPECT_GT(score(make_held_out_view(capture, gain, painter), model, painter).psnr_db, 55) << gain;
  }
}

TEST_F(HeldOut, GainAlignmentIsNeverWorseThanNone) {
  const PlainModel model(mesh, Eigen::Vector3f::Constant(level(120)));
  for (const int grey : {0, 1, 119, 120, 121, 255}) {
    const ViewScore result = score(make_held_out_view(uniform_capture(level(grey)), 1, painter), model, painter);
    EXPECT_GE(result.psnr_gain_aligned_db, result.psnr_db);
  }
}

TEST_F(HeldOut, ObjectPixelsAreTheSilhouetteErodedByThreeWithoutAMask) {
  const HeldOutView view = make_held_out_view(uniform_capture(1), 1, painter);
  const ImageU8 object = view.pixels().object;
  const ImageU8 whole = silhouette();
  ASSERT_GT(count(whole), 2000u);
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) {
      bool all = true;
      for (int dy = -3; dy <= 3; ++dy)
        for (int dx = -3; dx <= 3; ++dx)
          if (x + dx >= 0 && x + dx < 120 && y + dy >= 0 && y + dy < 90) all &= whole.at(x + dx, y + dy) != 0;
      ASSERT_EQ(object.at(x, y) != 0, all) << x << " " << y;
    }
}

TEST_F(HeldOut, ObjectPixelsAreTheSilhouetteInsideTheMask) {
  ImageU8 mask(120, 90, 1);
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) mask.at(x, y) = (x * 7 + y * 3) % 5 ? 1 : 0;
  const HeldOutView view = make_held_out_view(uniform_capture(1, mask), 1, painter);
  const ImageU8 object = view.pixels().object;
  const ImageU8 whole = silhouette();
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) ASSERT_EQ(object.at(x, y) != 0, whole.at(x, y) && mask.at(x, y));
}

TEST_F(HeldOut, InsideAreTheObjectPixelsThreeAwayFromItsEdge) {
  // The mask ends a pixel before the silhouette, and what it ends on is half the background, as of a camera.
  const PlainModel model(mesh, Eigen::Vector3f::Constant(level(120)));
  const ImageU8 mask = erode(silhouette(), 1), core = erode(mask, 3);
  Capture capture = uniform_capture(0, mask);
  ImageF pixels(120, 90, 3, level(124));
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (!core.data()[i]) std::fill_n(pixels.data() + 3 * i, 3, level(180));
  capture.image = analytic::float_image(pixels);
  const HeldOutView view = make_held_out_view(capture, 1, painter);
  EXPECT_EQ(count(view.pixels().inside), count(core));
  const ViewScore result = score(view, model, painter);
  EXPECT_NEAR(result.psnr_inside_db, 20 * std::log10(255.0 / 4), 1e-9);
  EXPECT_LT(result.psnr_db, result.psnr_inside_db - 5);
  EXPECT_EQ(score({view}, model, painter).psnr_inside_db, result.psnr_inside_db);

  const HeldOutView unmasked = make_held_out_view(uniform_capture(1), 1, painter);
  EXPECT_EQ(count(unmasked.pixels().inside), count(unmasked.pixels().object)) << "is away from the edge already";
}

TEST_F(HeldOut, ThePictureWithoutNoiseTakesThePlaceOfThePhotograph) {
  const TempFolder folder;
  HeldOutView view = make_held_out_view(uniform_capture(level(90)), 1, painter);
  view.name = "images/view_03.png";
  EXPECT_THROW(take_truth_from(folder.path(), view), FileError) << "there is none";
  write_exr(folder.path() / "view_03.exr", ImageF(60, 90, 3, level(125)));
  EXPECT_THROW(take_truth_from(folder.path(), view), FileError) << "of another size";
  write_exr(folder.path() / "view_03.exr", ImageF(120, 90, 3, level(125)));
  take_truth_from(folder.path(), view);
  const PlainModel model(mesh, Eigen::Vector3f::Constant(level(120)));
  EXPECT_NEAR(score(view, model, painter).psnr_db, 20 * std::log10(255.0 / 5), 1e-9);
}

TEST_F(HeldOut, PixelsThatAreNoNumbersDoNotCount) {
  const PlainModel model(mesh, Eigen::Vector3f::Constant(level(120)));
  ImageF pixels(120, 90, 3, level(124));
  pixels.at(60, 45, 1) = std::nanf("");
  pixels.at(62, 45, 0) = std::numeric_limits<float>::infinity();
  Capture capture = uniform_capture(0);
  capture.image = analytic::float_image(pixels);
  const HeldOutView view = make_held_out_view(capture, 1, painter);
  EXPECT_EQ(view.pixels().object.at(60, 45), 0);
  EXPECT_EQ(view.pixels().object.at(62, 45), 0);
  const HeldOutView whole = make_held_out_view(uniform_capture(1), 1, painter);
  EXPECT_EQ(count(view.pixels().object), count(whole.pixels().object) - 2);
  EXPECT_NEAR(score(view, model, painter).psnr_db, 20 * std::log10(255.0 / 4), 1e-9);
}

TEST_F(HeldOut, UncoveredIsTheShareOfObjectPixelsThatNoImageShowed) {
  PlainModel model(mesh);
  const HeldOutView view = make_held_out_view(uniform_capture(1), 1, painter);
  const ImageU8 shown = view.pixels().object;
  EXPECT_EQ(score(view, model, painter).uncovered, 0);
  std::size_t object = 0, unseen = 0;
  for (std::uint32_t t = 0; t < 16; ++t) model.unseen.insert(t);  // the half with y < 0
  const Rigid3 object_from_camera = kPose.inverse();
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) {
      if (!shown.at(x, y)) continue;
      const Eigen::Vector3d ray = object_from_camera.rotation * *camera().ray({double(x), double(y)});
      ++object;
      unseen += (object_from_camera.translation - object_from_camera.translation.z() / ray.z() * ray).y() < 0;
    }
  EXPECT_GT(unseen, object / 3);
  EXPECT_NEAR(score(view, model, painter).uncovered, double(unseen) / double(object), 1e-12);
}

TEST_F(HeldOut, ScoresAreMeansOverViewsAndPooledOverPixels) {
  const PlainModel model(mesh, Eigen::Vector3f::Constant(level(120)));
  ImageU8 few(120, 90, 1);
  for (int x = 40; x < 80; ++x) few.at(x, 45) = 255;
  const std::vector<HeldOutView> views{make_held_out_view(uniform_capture(level(122)), 1, painter),
                                       make_held_out_view(uniform_capture(level(130), few), 1, painter)};
  const Scores scores = score(views, model, painter);
  ASSERT_EQ(scores.views.size(), 2u);
  EXPECT_NEAR(scores.psnr_db, (20 * std::log10(255 / 2.0) + 20 * std::log10(255 / 10.0)) / 2, 1e-9);
  const auto pixels = [&](int i) { return static_cast<double>(count(views[i].pixels().object)); };
  const double a = pixels(0), b = pixels(1);
  EXPECT_NEAR(scores.psnr_pooled_db, 10 * std::log10(255 * 255 * (a + b) / (4 * a + 100 * b)), 1e-9);
  EXPECT_NEAR(scores.ssim, (scores.views[0].ssim + scores.views[1].ssim) / 2, 1e-12);
  EXPECT_TRUE(score(std::vector<HeldOutView>{}, model, painter).views.empty());
}

}  // namespace
}  // namespace sheen
