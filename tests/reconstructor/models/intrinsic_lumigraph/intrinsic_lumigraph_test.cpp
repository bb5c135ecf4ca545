// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/errors.h"
#include "common/image/color.h"
#include "common/image/image_metrics.h"
#include "reconstructor/models/intrinsic_lumigraph/image_geometry.h"
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_painter.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/reconstructor/models/intrinsic_lumigraph/small_rig.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

double psnr(const ImageF& a, const ImageF& b) {
  return squared_error(to_srgb8(a), to_srgb8(b), {}).psnr_db();
}

class IntrinsicLumigraphTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    rig_ = new SmallRig;
    model_ = rig_->model().release();
    snapshot_ = SmallRig::snapshot_of(*model_);
  }
  static void TearDownTestSuite() {
    snapshot_ = nullptr;
    delete model_;
    delete rig_;
  }
  static const LightRig& rig() { return rig_->rig; }

  static inline SmallRig* rig_ = nullptr;
  static inline IntrinsicLumigraph* model_ = nullptr;
  static inline std::shared_ptr<const IntrinsicLumigraphSnapshot> snapshot_;
};

TEST_F(IntrinsicLumigraphTest, MidwayPicturesAreTheTruth) {
  LumigraphPainter painter(snapshot_);
  for (const std::size_t m : {0u, 2u, 5u}) {
    const LightState& light = rig().midway_lights()[m];
    const SimulatedPicture truth = rig().picture(rig().cameras()[0], light);
    const double ours = psnr(painter.paint(rig().cameras()[0], light), truth.radiance),
                 linear = psnr(painter.paint_interpolated(rig().cameras()[0], light), truth.radiance);
    EXPECT_GT(ours, 45);
    EXPECT_GT(ours, linear + 15);
  }
}

TEST_F(IntrinsicLumigraphTest, ShadowsFallWhereTheyMust) {
  LumigraphPainter painter(snapshot_);
  const LightState& light = rig().midway_lights()[2];
  const ImageU8 arrives = painter.arrives(rig().cameras()[1], light);
  const ImageU8 shadow = rig().picture(rig().cameras()[1], light).shadow;
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < shadow.size(); ++i) {
    both += arrives.data()[i] < 128 && shadow.data()[i] != 0;
    either += arrives.data()[i] < 128 || shadow.data()[i] != 0;
  }
  EXPECT_GT(static_cast<double>(both), 0.98 * static_cast<double>(either));
}

TEST_F(IntrinsicLumigraphTest, ReflectanceIsThatOfTheScene) {
  const IntrinsicView& view = *snapshot_->data()->views[0];
  const SimulatedPicture truth = rig().picture(rig().cameras()[0], rig().lights()[0]);
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.reflectance.size(); ++i)
    if (truth.depth.data()[i / 3] > 0)
      errors.push_back(std::abs(static_cast<float>(view.reflectance.data()[i]) / truth.reflectance.data()[i] - 1));
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.01);
}

TEST_F(IntrinsicLumigraphTest, BetweenViewsItIsSharperThanInterpolation) {
  LumigraphPainter painter(snapshot_);
  const PosedCamera between = rig().camera_at(0.5, 0);
  const LightState& light = rig().midway_lights()[3];
  const ImageF truth = rig().picture(between, light).radiance;
  EXPECT_GT(psnr(painter.paint(between, light), truth), psnr(painter.paint_interpolated(between, light), truth) + 6);
}

/// At either border of a picture from between two views, one of them shows nothing.
TEST_F(IntrinsicLumigraphTest, WithoutAMeshNoBorderOfAViewIsSeen) {
  SmallRig images;
  images.mesh = std::make_shared<const Mesh>(view_plane(images.rig.central_camera()));
  const auto model = images.model();
  LumigraphPainter painter(SmallRig::snapshot_of(*model));
  const PosedCamera between = rig().camera_at(0.5, 0);
  const ImageF picture = painter.paint(between, rig().lights()[3]);
  for (int x = 0; x < picture.width(); ++x) EXPECT_GT(picture.at(x, 60, 1), 0.01f) << "column " << x;
}

TEST_F(IntrinsicLumigraphTest, WithoutAMeshWhatIsBesideAllImagesIsUnseenAndPlainGrey) {
  SmallRig images;
  images.mesh = std::make_shared<const Mesh>(view_plane(images.rig.central_camera()));
  const auto model = images.model();
  const auto snapshot = SmallRig::snapshot_of(*model);
  const Rigid3 pose = look_at({0.9, -0.9, 0.9}, {0, 0, 0}, {0, 0, 1});
  const PaintedView view =
      RayPainter(snapshot->mesh()).paint(*snapshot, rig().cameras()[0].camera, pose, rig().lights()[3]);
  int beside = 0;
  for (std::size_t i = 0; i < view.coverage.size(); ++i) {
    if (view.coverage.data()[i] == 0) continue;
    EXPECT_GT(view.beauty.data()[3 * i + 1], 0.005f) << "pixel " << i;
    beside +=
        view.coverage.data()[i] == kCoverageUnseen && std::abs(view.beauty.data()[3 * i] - srgb_decode(0.35f)) < 1e-6;
  }
  EXPECT_GT(beside, 100);
}

TEST_F(IntrinsicLumigraphTest, TheRayPainterAndTheQuickOneAgree) {
  LumigraphPainter quick(snapshot_);
  const RayPainter rays(snapshot_->mesh());
  for (const PosedCamera& from : {rig().cameras()[1], rig().camera_at(0.4, 0)}) {
    const LightState& light = rig().midway_lights()[1];
    const ImageF by_rays = rays.paint(*snapshot_, from.camera, from.camera_from_object, light).beauty;
    EXPECT_GT(psnr(quick.paint(from, light), by_rays), 50);
  }
}

/// What a painter remembers of the last picture changes none.
TEST_F(IntrinsicLumigraphTest, PicturesDoNotDependOnThoseBefore) {
  LumigraphPainter one(snapshot_);
  const LightState &a = rig().midway_lights()[1], &b = rig().midway_lights()[3];
  LightState red = a;
  red.rgb = {2, 1, 0.5f};
  for (const auto& [x, light] : {std::pair{0.2, a}, {0.4, a}, {0.4, b}, {0.7, b}, {0.7, red}, {0.0, red}, {0.3, a}}) {
    const PosedCamera from = rig().camera_at(x, 0);
    EXPECT_EQ(one.paint(from, light), LumigraphPainter(snapshot_).paint(from, light)) << x;
  }
}

TEST_F(IntrinsicLumigraphTest, ColouredLightIsTakenOut) {
  const SmallRig one;
  IntrinsicLumigraph white(one.mesh, {}), red(one.mesh, {});
  for (std::size_t l = 0; l < 3; ++l) {
    Capture capture = one.capture(0, l);
    white.ingest(capture);
    LightState dim = one.rig.lights()[l];
    ImageF radiance = one.rig.picture(one.rig.cameras()[0], dim).radiance;
    dim.rgb = {1.0f, 0.5f, 0.25f};
    for (std::size_t i = 0; i < radiance.size(); ++i) radiance.data()[i] *= dim.rgb[static_cast<Eigen::Index>(i % 3)];
    red.ingest(rig_capture(one.rig.cameras()[0], dim, radiance, l + 1));
  }
  const LightState light = one.rig.midway_lights()[1];
  EXPECT_GT(psnr(LumigraphPainter(SmallRig::snapshot_of(red)).paint(one.rig.cameras()[0], light),
                 LumigraphPainter(SmallRig::snapshot_of(white)).paint(one.rig.cameras()[0], light)),
            42);
}

TEST_F(IntrinsicLumigraphTest, RefusesWhatItCannotUse) {
  Capture capture = rig_->capture(0, 0);
  EXPECT_EQ(model_->ingest(capture).reason, "same_view_and_light");
  capture.light = {};
  EXPECT_EQ(model_->ingest(capture).reason, "no_light_position");
  capture.light = {.kind = LightKind::kDirectional, .position = {0, 0, 1}};
  EXPECT_EQ(model_->ingest(capture).reason, "other_kind_of_light");
  capture.light = {.kind = LightKind::kPoint, .position = {0, std::nan(""), 1}};
  EXPECT_EQ(model_->ingest(capture).reason, "broken_light");
  capture.pose.status = PoseStatus::kNoTags;
  EXPECT_EQ(model_->ingest(capture).reason, "no_pose");
  EXPECT_THROW(snapshot_->light_place({.kind = LightKind::kDirectional, .position = {0, 0, 1}}), ConfigError);
}

TEST_F(IntrinsicLumigraphTest, AnImageTakenBackLeavesNoTrace) {
  const SmallRig one;
  IntrinsicLumigraph without(one.mesh, {}), with(one.mesh, {});
  for (std::size_t l = 0; l < 4; ++l) {
    without.ingest(one.capture(0, l));
    with.ingest(one.capture(0, l));
  }
  with.snapshot();
  const Capture more = one.capture(0, 5);
  with.ingest(more);
  with.snapshot();
  EXPECT_TRUE(with.withdraw(more));
  EXPECT_FALSE(with.withdraw(more));
  const LightState light = one.rig.midway_lights()[1];
  const PosedCamera& from = one.rig.cameras()[0];
  EXPECT_EQ(LumigraphPainter(SmallRig::snapshot_of(with)).paint(from, light),
            LumigraphPainter(SmallRig::snapshot_of(without)).paint(from, light));
  EXPECT_EQ(with.figures().images, 4u);
}

/// A Lambertian plane under a moving point light, all in closed form, in a mesh of its own and HDR pixels.
TEST(IntrinsicLumigraphPlaneTest, FollowsTheClosedForm) {
  Mesh square;
  square.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  const PosedCamera from{{.width = 40, .height = 30, .fx = 40, .fy = 40, .cx = 19.5, .cy = 14.5},
                         look_at({0, -0.4, 1}, {0, 0, 0}, {0, 0, 1})};
  const Rigid3 object_from_camera = from.camera_from_object.inverse();
  const auto picture = [&](const Vector3d& lamp) {
    ImageF image(40, 30, 3);
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x) {
        const Vector3d ray = object_from_camera.rotation * *from.camera.ray({double(x), double(y)});
        const Vector3d point = object_from_camera.translation - ray * (object_from_camera.translation.z() / ray.z());
        const Vector3d to = lamp - point;
        for (int c = 0; c < 3; ++c)
          image.at(x, y, c) = static_cast<float>((0.2 + 0.1 * c + 0.01 * (x % 7)) * to.z() / std::pow(to.norm(), 3));
      }
    return image;
  };
  const auto lamp = [](double turn) { return Vector3d(std::cos(turn), std::sin(turn), 1.2); };
  IntrinsicLumigraph model(std::make_shared<const Mesh>(square), {});
  for (int i = 0; i < 6; ++i) {
    const LightState light{.kind = LightKind::kPoint, .position = lamp(i)};
    EXPECT_EQ(model.ingest(rig_capture(from, light, picture(light.position), i + 1)).status, IngestStatus::kAccepted);
  }
  LumigraphPainter painter(SmallRig::snapshot_of(model));
  for (const double turn : {0.5, 2.3, 4.1}) {
    const LightState light{.kind = LightKind::kPoint, .position = lamp(turn)};
    EXPECT_GT(psnr(painter.paint(from, light), picture(light.position)), 50);
  }
}

/// A sheet that is red above and green below, each side seen and lit by itself.
class TwoSidedSheet : public ::testing::Test {
 protected:
  static PosedCamera seen_from(const Vector3d& eye) {
    return {{.width = 40, .height = 30, .fx = 40, .fy = 40, .cx = 19.5, .cy = 14.5},
            look_at(eye, {0, 0, 0}, {0, 1, 0})};
  }
  static LightState lamp(double turn, double side) {
    return {.kind = LightKind::kPoint, .position = {std::cos(turn), std::sin(turn), 1.2 * side}};
  }
  void take(IntrinsicLumigraph& model, double side) {
    const PosedCamera from = seen_from({0, -0.4, side});
    for (int i = 0; i < 4; ++i) {
      ImageF image(40, 30, 3);
      for (std::size_t p = 0; p < image.size(); ++p) image.data()[p] = p % 3 == (side > 0 ? 0 : 1) ? 0.4f : 0.05f;
      model.ingest(rig_capture(from, lamp(i, side), std::move(image), ++sequence_));
    }
  }
  /// At the middle of a picture from another eye on that side.
  static PaintedView seen(const IntrinsicLumigraphSnapshot& model, double side) {
    const PosedCamera from = seen_from({0.1, 0.3, side});
    const PaintedView view = RayPainter(model.mesh()).paint(model, from.camera, from.camera_from_object, lamp(1, side));
    const auto shared = std::make_shared<IntrinsicLumigraphSnapshot>(model);
    EXPECT_GT(psnr(LumigraphPainter(shared).paint(from, lamp(1, side)), view.beauty), 50);
    return view;
  }

  std::shared_ptr<const Mesh> square_ = std::make_shared<const Mesh>(
      Mesh{.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, .triangles = {{0, 1, 2}, {0, 2, 3}}});
  std::uint64_t sequence_ = 0;
};

TEST_F(TwoSidedSheet, TheInsideDoesNotWearTheOutsidesPattern) {
  IntrinsicLumigraph model(square_, {});
  take(model, 1);
  const PaintedView inside = seen(*SmallRig::snapshot_of(model), -1);
  const float* rgb = inside.beauty.pixel(20, 15);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], srgb_decode(0.35f), 1e-6);
  EXPECT_EQ(inside.coverage.at(20, 15), kCoverageUnseen);
}

TEST_F(TwoSidedSheet, ImagesOfTheInsideShowIt) {
  IntrinsicLumigraph model(square_, {});
  take(model, 1);
  take(model, -1);
  for (const int side : {1, -1}) {
    const PaintedView view = seen(*SmallRig::snapshot_of(model), side);
    const float* rgb = view.beauty.pixel(20, 15);
    EXPECT_GT(rgb[side > 0 ? 0 : 1], 5 * rgb[side > 0 ? 1 : 0]) << side;
    EXPECT_EQ(view.coverage.at(20, 15), kCoverageMeasured);
  }
}

}  // namespace
}  // namespace sheen
