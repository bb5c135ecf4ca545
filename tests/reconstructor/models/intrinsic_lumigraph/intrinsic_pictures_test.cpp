// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_pictures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reconstructor/models/intrinsic_lumigraph/image_geometry.h"
#include "reconstructor/render/ray_painter.h"
#include "reconstructor/render/surface_pictures.h"
#include "tests/reconstructor/models/intrinsic_lumigraph/small_rig.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

ImageF painted(const ModelSnapshot& model, SurfaceProperty property, const PosedCamera& from, const LightState& light) {
  const auto appearance = dynamic_cast<const KnownSurface&>(model).property(property);
  return RayPainter(model.mesh()).paint(*appearance, from.camera, from.camera_from_object, light).beauty;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

class IntrinsicPicturesTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    rig_ = new SmallRig;
    snapshot_ = SmallRig::snapshot_of(*rig_->model());
  }
  static void TearDownTestSuite() {
    snapshot_ = nullptr;
    delete rig_;
  }
  static const LightRig& rig() { return rig_->rig; }
  static inline SmallRig* rig_ = nullptr;
  static inline std::shared_ptr<const IntrinsicLumigraphSnapshot> snapshot_;
};

TEST_F(IntrinsicPicturesTest, ReflectanceTimesIlluminationIsTheMattScene) {
  const PosedCamera& from = rig().cameras()[0];
  const LightState& light = rig().midway_lights()[2];
  const SimulatedPicture truth = rig().picture(from, light);
  const ImageF reflectance = painted(*snapshot_, SurfaceProperty::kReflectance, from, light),
               illumination = painted(*snapshot_, SurfaceProperty::kIllumination, from, light);
  std::vector<double> of_reflectance, of_radiance;
  for (std::size_t i = 0; i < truth.radiance.size(); ++i) {
    if (!(truth.depth.data()[i / 3] > 0) || !(truth.radiance.data()[i] > 0.02f)) continue;
    of_reflectance.push_back(std::abs(reflectance.data()[i] / truth.reflectance.data()[i] - 1));
    of_radiance.push_back(std::abs(reflectance.data()[i] * illumination.data()[i] / truth.radiance.data()[i] - 1));
  }
  ASSERT_GT(of_radiance.size(), 1000u);
  EXPECT_LT(median(of_reflectance), 0.01);
  EXPECT_LT(median(of_radiance), 0.02);
}

TEST_F(IntrinsicPicturesTest, IlluminationHasTheColourOfTheLightAndReflectanceHasNot) {
  const PosedCamera& from = rig().cameras()[1];
  LightState white = rig().midway_lights()[1], red = white;
  red.rgb = {2, 1, 0.5f};
  const ImageF in_white = painted(*snapshot_, SurfaceProperty::kIllumination, from, white),
               in_red = painted(*snapshot_, SurfaceProperty::kIllumination, from, red);
  for (std::size_t i = 0; i < in_white.size(); ++i)
    EXPECT_NEAR(in_red.data()[i], red.rgb[static_cast<Eigen::Index>(i % 3)] * in_white.data()[i], 1e-5);
  const ImageF a = painted(*snapshot_, SurfaceProperty::kReflectance, from, white),
               b = painted(*snapshot_, SurfaceProperty::kReflectance, from, red);
  EXPECT_TRUE(std::equal(a.data(), a.data() + a.size(), b.data()));
}

/// A square plate above the ground casts the square that a lamp projects: a point is in shadow where the line to the
/// lamp passes through the plate.
TEST(IntrinsicPicturesOfAPlate, ShadowIsTheSquareThatTheLampProjects) {
  constexpr float kGround = 0.5f, kPlate = 0.08f, kHeight = 0.15f;
  auto mesh = std::make_shared<Mesh>();
  for (const auto& [half, z] : {std::pair{kGround, 0.0f}, std::pair{kPlate, kHeight}}) {
    const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
    for (const auto& [x, y] : {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}})
      mesh->vertices.push_back({static_cast<float>(x) * half, static_cast<float>(y) * half, z});
    mesh->triangles.push_back({first, first + 1, first + 2});
    mesh->triangles.push_back({first, first + 2, first + 3});
  }
  const Camera camera{.width = 160, .height = 120, .fx = 150, .fy = 150, .cx = 79.5, .cy = 59.5};
  const PosedCamera from{camera, look_at({0, -0.8, 0.7}, Vector3d::Zero(), Vector3d::UnitZ())};
  const auto plate_hides = [&](const Vector3d& point, const Vector3d& lamp) {
    const Vector3d crossing = point + (kHeight - point.z()) / (lamp.z() - point.z()) * (lamp - point);
    return point.z() < kHeight / 2 && std::max(std::abs(crossing.x()), std::abs(crossing.y())) < kPlate;
  };
  const RayPainter painter(*mesh);
  const std::vector<Hit> hits = painter.cast(camera, from.camera_from_object);
  const ImageF depth = depth_picture(*mesh, hits, from);
  const auto place_at = [&](int x, int y, double dx, double dy) -> Vector3d {
    const Vector3d ray = *camera.ray({x + dx, y + dy});
    const Rigid3 object_from_camera = from.camera_from_object.inverse();
    const Vector3d eye = object_from_camera.translation, direction = object_from_camera.rotation * ray;
    const double z = depth.at(x, y) < 1e9f ? (object_from_camera * (ray / ray.z() * double(depth.at(x, y)))).z() : 0;
    const double plane = z > kHeight / 2 ? kHeight : 0;
    return eye + (plane - eye.z()) / direction.z() * direction;
  };

  IntrinsicLumigraph model(mesh, IntrinsicLumigraphOptions());
  std::vector<LightState> lights;
  for (const auto& [x, y] : {std::pair{0.4, 0.0}, std::pair{-0.3, 0.3}, std::pair{-0.3, -0.3}})
    lights.push_back({LightKind::kPoint, {x, y, 0.9}});
  for (std::size_t l = 0; l < lights.size(); ++l) {
    ImageF radiance(camera.width, camera.height, 3);
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        for (int c = 0; c < 3; ++c)
          radiance.at(x, y, c) = plate_hides(place_at(x, y, 0, 0), lights[l].position) ? 0.05f : 0.4f;
    model.ingest(rig_capture(from, lights[l], radiance, l + 1));
  }
  const LightState between{LightKind::kPoint, {0.05, 0.1, 0.9}};
  const ImageF shadow = painted(*model.snapshot(), SurfaceProperty::kShadow, from, between);
  int dark = 0, lit = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      if (!hits[static_cast<std::size_t>(y * camera.width + x)]) continue;
      const bool hidden = plate_hides(place_at(x, y, 0, 0), between.position);
      bool edge = false;
      for (const double dx : {-1.0, 1.0})
        for (const double dy : {-1.0, 1.0}) {
          const Vector3d beside = place_at(x, y, dx, dy);
          const bool other_surface = x < 1 || y < 1 || x > camera.width - 2 || y > camera.height - 2 ||
                                     !(std::abs(depth.at(x + int(dx), y + int(dy)) - depth.at(x, y)) < 0.05f);
          edge |= other_surface || plate_hides(beside, between.position) != hidden;
        }
      if (edge) continue;
      EXPECT_EQ(shadow.at(x, y, 0), hidden ? 1 : 0) << x << " " << y;
      ++(hidden ? dark : lit);
    }
  EXPECT_GT(dark, 200);
  EXPECT_GT(lit, 3000);
}

TEST_F(IntrinsicPicturesTest, WithoutAMeshDepthAndShadowsAreThoseOfTheImages) {
  SmallRig images;
  images.mesh = std::make_shared<const Mesh>(view_plane(images.rig.central_camera()));
  const auto model = SmallRig::snapshot_of(*images.model());
  EXPECT_FALSE(model->is_mesh());
  const PosedCamera& from = rig().cameras()[0];
  const LightState& light = rig().lights()[2];
  const SimulatedPicture truth = rig().picture(from, light);
  const ImageF places = painted(*model, SurfaceProperty::kPlace, from, light),
               shadow = painted(*model, SurfaceProperty::kShadow, from, light);
  const ImageF depth = depth_picture(
      places, std::vector<bool>(static_cast<std::size_t>(from.camera.width) * from.camera.height, true), from);
  std::vector<double> errors;
  double both = 0, either = 0;
  for (std::size_t i = 0; i < truth.depth.size(); ++i) {
    if (!(truth.depth.data()[i] > 0)) continue;
    errors.push_back(std::abs(depth.data()[i] / truth.depth.data()[i] - 1));
    const bool told = shadow.data()[3 * i] > 0.5f, is = truth.shadow.data()[i] != 0;
    both += told && is;
    either += told || is;
  }
  EXPECT_LT(median(errors), 0.02);
  EXPECT_GT(both / either, 0.7);
}

TEST_F(IntrinsicPicturesTest, NoImagesSayNothing) {
  IntrinsicLumigraph model(rig_->mesh, IntrinsicLumigraphOptions());
  const ImageF nothing =
      painted(*model.snapshot(), SurfaceProperty::kReflectance, rig().cameras()[0], rig().lights()[0]);
  EXPECT_TRUE(std::all_of(nothing.data(), nothing.data() + nothing.size(), [](float value) { return value == 0; }));
}

}  // namespace
}  // namespace sheen
