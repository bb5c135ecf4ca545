// SPDX-License-Identifier: Apache-2.0
// What eyes see that stand where no camera stood: lumigraphs of one ring of cameras, looked at from all round.
#include "tests/reconstructor/models/beyond_views.h"

#include <gtest/gtest.h>

#include "common/image/image_metrics.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph.h"
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_painter.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using namespace beyond_views;
using Eigen::Vector3d;

/// A ball with a pattern that shines a little, in the light of one of three far lamps and of all that is round it.
class LumigraphBeyondViews : public ::testing::TestWithParam<Ring> {
 protected:
  static LightState light(int i) {
    const Vector3d towards[] = {{0.1, 0, 1}, {1, 0.2, 0.8}, {-0.5, 0.8, 0.7}};
    return {.kind = LightKind::kDirectional, .position = towards[i].normalized()};
  }
  static analytic::Scene scene(int i) {
    const Vector3d lamp = light(i).position;
    return {analytic::sphere(kRadius), [lamp](const Vector3d& p, const Vector3d& to_eye) {
              const Vector3d n = p.normalized(), mirrored = 2 * n.dot(to_eye) * n - to_eye;
              const double matt = 0.2 + 0.8 * std::max(0.0, n.dot(lamp));
              const double lobe = n.dot(lamp) > 0 ? 0.15 * std::pow(std::max(0.0, mirrored.dot(lamp)), 12) : 0;
              return Vector3d((0.6 * matt * analytic::waves(p, 0.05)).array() + lobe);
            }};
  }
  static PosedCamera camera(const Vector3d& eye) {
    return {{.width = 160, .height = 120, .fx = 250, .fy = 250, .cx = 79.5, .cy = 59.5}, analytic::towards_origin(eye)};
  }
  std::shared_ptr<const IntrinsicLumigraphSnapshot> model() const {
    IntrinsicLumigraphOptions options;
    options.hold_out_every = 0;
    IntrinsicLumigraph model(mesh_, options);
    std::uint64_t sequence = 0;
    for (const Vector3d& eye : GetParam().eyes())
      for (int i = 0; i < 3; ++i) {
        Capture capture = analytic::capture(scene(i), camera(eye).camera, camera(eye).camera_from_object);
        capture.light = light(i);
        capture.sequence = ++sequence;
        EXPECT_EQ(model.ingest(capture).status, IngestStatus::kAccepted);
      }
    return std::dynamic_pointer_cast<const IntrinsicLumigraphSnapshot>(model.snapshot());
  }

  std::shared_ptr<const Mesh> mesh_ = std::make_shared<const Mesh>(sphere_mesh(float(kRadius), 4));
};

TEST_P(LumigraphBeyondViews, ColoursStayWithinWhatWasSeenAndChangeSmoothly) {
  const auto snapshot = model();
  constexpr double kSlanting = 0.15;  // there a pixel of a view covers a sixth of a wave of the pattern
  // Where light begins the facets of the mesh decide, and how many of them a pixel covers.
  const auto not_there = [](const Place& at) { return std::abs(at.normal.dot(light(1).position)) > 0.2; };
  Walk w =
      walk(*snapshot, scene(1), GetParam().eyes(), {.light = light(1), .slanting = kSlanting, .counts = not_there});
  ASSERT_GT(w.excess.size(), 1000u);
  EXPECT_LT(Walk::quantile(w.excess, 0.99), 12);
  EXPECT_LT(Walk::quantile(w.excess, 1), 32);
  EXPECT_LT(Walk::quantile(w.flicker, 1), 6);
}

/// What no view shows is a guess, and neither black nor burnt.
TEST_P(LumigraphBeyondViews, GuessesLookLikeTheRest) {
  const auto snapshot = model();
  const RayPainter painter(*mesh_);
  for (const double elevation : {-85.0, -40.0, 10.0, 85.0})
    for (const double azimuth : {5.0, 125.0, 245.0}) {
      const PosedCamera from = camera(eye_at(elevation, azimuth));
      const PaintedView view = painter.paint(*snapshot, from.camera, from.camera_from_object, light(1));
      const ImageF quick = LumigraphPainter(snapshot).paint(from, light(1));
      for (std::size_t i = 0; i < view.coverage.size(); ++i) {
        if (view.coverage.data()[i] == 0) continue;
        for (std::size_t c = 0; c < 3; ++c) {
          ASSERT_GT(view.beauty.data()[3 * i + c], 0.01f) << elevation << " " << azimuth << " pixel " << i;
          ASSERT_LT(view.beauty.data()[3 * i + c], 0.7f) << elevation << " " << azimuth << " pixel " << i;
        }
      }
      EXPECT_GT(squared_error(to_srgb8(quick), to_srgb8(view.beauty), {}).psnr_db(), 40);
    }
}

INSTANTIATE_TEST_SUITE_P(Rings, LumigraphBeyondViews,
                         ::testing::Values(Ring{"OneCamera", 1, 20}, Ring{"ThreeCameras", 3, 20},
                                           Ring{"TwelveCameras", 12, 20}, Ring{"High", 24, 60},
                                           Ring{"ShortArc", 12, 40, 60}),
                         [](const auto& ring) { return ring.param.name; });

}  // namespace
}  // namespace sheen
