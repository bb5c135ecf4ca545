// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/irradiance_field.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/capture/rig_motion.h"
#include "common/image/color.h"
#include "common/image/image_metrics.h"
#include "reconstructor/models/irradiance_field/field_file.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/reconstructor/models/irradiance_field/lambertian_relief.h"
#include "tests/support/expect_error.h"

namespace sheen {
namespace {

LightState directional(const Eigen::Vector3d& direction, const Eigen::Vector3f& rgb = Eigen::Vector3f::Ones()) {
  return {.kind = LightKind::kDirectional, .position = direction, .rgb = rgb};
}

const IrradianceFieldSnapshot& field_of(const std::shared_ptr<const ModelSnapshot>& snapshot) {
  return dynamic_cast<const IrradianceFieldSnapshot&>(*snapshot);
}

/// Largest difference of two pictures in grey levels of their encoded values.
double largest_difference(const ImageF& a, const ImageF& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, 255.0 * std::abs(srgb_encode(a.data()[i]) - srgb_encode(b.data()[i])));
  return most;
}

TEST(IrradianceFieldTest, ShowsItsOwnImagesAgain) {
  const LambertianRelief relief;
  const auto snapshot = relief.model(dome_of_lights())->snapshot();
  for (const Eigen::Vector3d& light : dome_of_lights())
    EXPECT_LT(largest_difference(field_of(snapshot).picture(directional(light)), relief.picture(light)), 1);
}

/// The closed form: albedo times N.L, in lights that it never saw.
TEST(IrradianceFieldTest, RelightsALambertianSurface) {
  const LambertianRelief relief;
  const auto snapshot = relief.model(dome_of_lights())->snapshot();
  for (const Eigen::Vector3d& light : dome_of_lights(9)) {
    if (light.z() < 0.5) continue;
    EXPECT_LT(largest_difference(field_of(snapshot).picture(directional(light)), relief.picture(light)), 1)
        << light.transpose();
  }
}

/// A smooth relief on the plane at a metre from the camera, in tangents of its rays.
Eigen::Vector3f relief_at(const Eigen::Vector2d& at, const Eigen::Vector3d& light) {
  const double x = at.x(), y = at.y();
  const Eigen::Vector3d normal = Eigen::Vector3d(0.1 * std::sin(9 * x), 0.1 * std::cos(7 * y), 1).normalized();
  return Eigen::Vector3d(0.4 + 0.2 * std::sin(12 * x + 3 * y), 0.5, 0.4 + 0.2 * std::cos(11 * y)).cast<float>() *
         static_cast<float>(std::max(0.0, normal.dot(light.normalized())));
}
ImageF seen_relief(const Camera& camera, const Eigen::Vector3d& light) {
  ImageF image(camera.width, camera.height, 3);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray = *camera.ray({x, y});
      Eigen::Map<Eigen::Vector3f>(image.pixel(x, y)) = relief_at(ray.head<2>() / ray.z(), light);
    }
  return image;
}

/// Images of a lens with distortion make a flat field, which that lens sees as its own images.
TEST(IrradianceFieldTest, TheLensIsTakenOutOfEachImage) {
  const LambertianRelief relief;
  for (const std::array<double, 5>& distortion :
       {std::array<double, 5>{-0.2, 0.05, 0.002, -0.001, 0}, {0.15, 0, 0, 0.003, 0}}) {
    PosedCamera lens = relief.camera();
    lens.camera.distortion = distortion;
    const IrradianceFieldOptions options;
    IrradianceField model(std::make_shared<const Mesh>(*options.own_mesh(lens)), options);
    const std::vector<Eigen::Vector3d> lights = dome_of_lights();
    for (std::size_t i = 0; i < lights.size(); ++i) {
      Capture capture = relief.capture(lights[i], i + 1);
      capture.camera = lens.camera;
      const ImageF image = seen_relief(lens.camera, lights[i]);
      std::memcpy(capture.image.bytes.data(), image.data(), capture.image.bytes.size());
      ASSERT_EQ(model.ingest(capture).status, IngestStatus::kAccepted);
    }
    const auto snapshot = model.snapshot();
    const PosedCamera flat = snapshot->cameras().front();
    EXPECT_FALSE(flat.camera.has_distortion());
    const Eigen::Vector3d light(0.3, -0.2, 0.9);
    EXPECT_LT(largest_difference(field_of(snapshot).picture(directional(light.normalized())),
                                 seen_relief(flat.camera, light)),
              1.5);
    const RayPainter painter(snapshot->mesh());
    const PaintedView painted =
        painter.paint(*snapshot, lens.camera, lens.camera_from_object, directional(light.normalized()));
    const ImageF truth = seen_relief(lens.camera, light);
    std::size_t seen = 0;
    for (int y = 2; y + 2 < truth.height(); ++y)
      for (int x = 2; x + 2 < truth.width(); ++x) {
        const float* shown = painted.beauty.pixel(x, y);
        if (shown[1] == 0) continue;
        ++seen;
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(255 * srgb_encode(shown[c]), 255 * srgb_encode(truth.at(x, y, c)), 2) << x << ' ' << y;
      }
    EXPECT_GT(seen, truth.size() / 3 * 4 / 5) << "little is cut off";
  }
  PosedCamera wide = relief.camera();
  wide.camera.lens = LensModel::kFisheye;
  wide.camera.fx = wide.camera.fy = 20;
  wide.camera.distortion = {0.01, 0, 0, 0, 0};
  expect_error<ConfigError>([&] { IrradianceFieldOptions().own_mesh(wide); }, {"flat", "68 degrees"});
}

TEST(IrradianceFieldTest, TheScreensPictureIsTheSameButForRounding) {
  const LambertianRelief relief;
  const auto snapshot = relief.model(dome_of_lights())->snapshot();
  for (const Eigen::Vector3f& rgb : {Eigen::Vector3f(1, 1, 1), Eigen::Vector3f(1, 0.5f, 3)}) {
    const ImageU8 shown = field_of(snapshot).screen_picture(directional({0.2, 0.3, 0.9}, rgb)),
                  expected = to_srgb8(field_of(snapshot).picture(directional({0.2, 0.3, 0.9}, rgb)));
    ASSERT_EQ(shown.size(), expected.size());
    int differ = 0;
    for (std::size_t i = 0; i < shown.size(); ++i) {
      ASSERT_LE(std::abs(shown.data()[i] - expected.data()[i]), 1);
      differ += shown.data()[i] != expected.data()[i];
    }
    EXPECT_LE(differ, 5);
  }
}

TEST(IrradianceFieldTest, ColouredLightScalesRadiance) {
  const LambertianRelief relief;
  const auto snapshot = relief.model(dome_of_lights())->snapshot();
  const ImageF white = field_of(snapshot).picture(directional({0.2, 0.3, 0.9})),
               coloured = field_of(snapshot).picture(directional({0.2, 0.3, 0.9}, {2, 0.5f, 1}));
  for (int c = 0; c < 3; ++c)
    EXPECT_FLOAT_EQ(coloured.at(11, 7, c), Eigen::Vector3f(2, 0.5f, 1)[c] * white.at(11, 7, c));
}

/// A lamp of another colour and brightness tells the same of the scene.
TEST(IrradianceFieldTest, TheLampsColourIsDividedOut) {
  const LambertianRelief relief;
  auto model = relief.model({});
  std::uint64_t sequence = 0;
  for (const Eigen::Vector3d& light : dome_of_lights()) {
    Capture capture = relief.capture(light, ++sequence);
    capture.light.rgb = {0.5f, 2, 1};
    auto* values = reinterpret_cast<float*>(capture.image.bytes.data());
    for (std::size_t i = 0; i < capture.image.bytes.size() / sizeof(float); ++i)
      values[i] *= capture.light.rgb[static_cast<Eigen::Index>(i % 3)];
    ASSERT_EQ(model->ingest(capture).status, IngestStatus::kAccepted);
  }
  const Eigen::Vector3d light = dome_of_lights()[20];
  EXPECT_LT(largest_difference(field_of(model->snapshot()).picture(directional(light)), relief.picture(light)), 1);
}

TEST(IrradianceFieldTest, IsPaintedPixelByPixel) {
  const LambertianRelief relief;
  const auto snapshot = relief.model(dome_of_lights())->snapshot();
  const LightState light = directional({0.3, 0.1, 0.9});
  const PaintedView painted =
      RayPainter(snapshot->mesh()).paint(*snapshot, relief.camera().camera, relief.camera().camera_from_object, light);
  const ImageF picture = field_of(snapshot).picture(light);
  EXPECT_LT(largest_difference(painted.beauty, picture), 0.05);
  for (std::size_t i = 0; i < painted.coverage.size(); ++i) ASSERT_EQ(painted.coverage.data()[i], kCoverageMeasured);
}

TEST(IrradianceFieldTest, PredictsItsError) {
  LambertianRelief matt;
  const auto lights = dome_of_lights();
  std::vector<Eigen::Vector3d> few;
  for (std::size_t i = 0; i < lights.size(); i += 3) few.push_back(lights[i]);
  const double dense = field_of(matt.model(lights)->snapshot()).scene().error,
               sparse = field_of(matt.model(few)->snapshot()).scene().error;
  EXPECT_GT(dense, 0);
  EXPECT_GT(sparse, dense);
}

// A rotation is a quaternion up to its sign, and what travels is rounded: the model accepts whatever `auto`, which
// chose it, calls a camera that stands still.
TEST(IrradianceFieldTest, ACameraStandsStillForTheModelAsItDoesForAuto) {
  const LambertianRelief relief;
  auto model = relief.model({{0, 0, 1}, {0.5, 0, 0.8}});
  Capture capture = relief.capture({0, 0.5, 0.8}, 9);
  MotionWatch watch;
  watch.look({capture.camera, capture.pose.camera_from_object}, capture.light);
  Rigid3& pose = capture.pose.camera_from_object;
  pose.rotation.coeffs() *= -1;
  pose.translation *= 1 + 1e-7;
  watch.look({capture.camera, pose}, capture.light);
  EXPECT_EQ(watch.motion().camera, Motion::kStill);
  EXPECT_EQ(model->ingest(capture).status, IngestStatus::kAccepted);
}

TEST(IrradianceFieldTest, RefusesWhatIsNoneOfItsImages) {
  const LambertianRelief relief;
  auto model = relief.model({{0, 0, 1}, {0.5, 0, 0.8}});
  const auto reason = [&](const auto& change) {
    Capture capture = relief.capture({0, 0.5, 0.8}, 9);
    change(capture);
    const IngestReport report = model->ingest(capture);
    EXPECT_EQ(report.status, IngestStatus::kRefused);
    return report.reason;
  };
  EXPECT_EQ(reason([](Capture& c) { c.pose.status = PoseStatus::kNoTags; }), "no_pose");
  EXPECT_EQ(reason([](Capture& c) { c.light = {}; }), "no_light_position");
  EXPECT_EQ(reason([](Capture& c) { c.light.kind = LightKind::kPoint; }), "other_kind_of_light");
  EXPECT_EQ(reason([](Capture& c) { c.light.position.setZero(); }), "broken_light");
  EXPECT_EQ(reason([](Capture& c) { c.light.rgb.x() = 0; }), "broken_light");
  EXPECT_EQ(reason([](Capture& c) { c.light.position = {0, 0, 2}; }), "same_light");
  EXPECT_EQ(reason([](Capture& c) { c.camera.fx += 1; }), "other_camera");
  EXPECT_EQ(reason([](Capture& c) { c.pose.camera_from_object.translation.x() += 0.01; }), "other_camera");
  EXPECT_EQ(reason([](Capture& c) {
              reinterpret_cast<float*>(c.image.bytes.data())[5] = std::numeric_limits<float>::quiet_NaN();
            }),
            "broken_pixels");
  EXPECT_EQ(model->figures().images, 2u);
}

TEST(IrradianceFieldTest, AnImageThatIsTakenBackWasNeverThere) {
  const LambertianRelief relief;
  auto lights = dome_of_lights();
  auto model = relief.model(lights);
  EXPECT_TRUE(model->withdraw(relief.capture(lights[5], 6)));
  EXPECT_FALSE(model->withdraw(relief.capture(lights[5], 6)));
  lights.erase(lights.begin() + 5);
  const LightState light = directional({0.1, 0.2, 0.9});
  EXPECT_EQ(field_of(model->snapshot()).picture(light), field_of(relief.model(lights)->snapshot()).picture(light));
}

TEST(IrradianceFieldTest, WithoutAnImageItIsBlack) {
  const LambertianRelief relief;
  const auto snapshot = relief.model({})->snapshot();
  EXPECT_TRUE(snapshot->empty());
  EXPECT_EQ(snapshot->figures().seen, 0);
  const PaintedView painted =
      RayPainter(snapshot->mesh()).paint(*snapshot, relief.camera().camera, relief.camera().camera_from_object);
  EXPECT_EQ(painted.beauty.at(3, 3), 0);
  EXPECT_EQ(painted.coverage.at(3, 3), kCoverageUnseen);
}

TEST(IrradianceFieldTest, IsNotAskedForAnotherKindOfLight) {
  const LambertianRelief relief;
  const auto snapshot = relief.model(dome_of_lights())->snapshot();
  EXPECT_EQ(snapshot->light_kind(), LightKind::kDirectional);
  expect_error<ConfigError>(
      [&] {
        snapshot->shader_for({{}, {.kind = LightKind::kPoint, .position = {0, 0, 1}}});
      },
      {"built in directional light"});
}

TEST(IrradianceFieldTest, TakesNoMesh) {
  Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  expect_error<ConfigError>([&] { IrradianceField(std::make_shared<const Mesh>(mesh), {}); }, {"list of lights"});
}

}  // namespace
}  // namespace sheen
