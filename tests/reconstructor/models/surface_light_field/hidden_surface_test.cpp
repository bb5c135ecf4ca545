// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "common/image/linear_reader.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

constexpr double kDistance = 0.5, kLowest = 0.55;

/// Masks the pixels whose place on the plane z = 0 is hidden, and spoils their colour.
Capture hide(Capture capture, const std::function<bool(double x, double y)>& hidden) {
  const Rigid3 object_from_camera = capture.pose.camera_from_object.inverse();
  const Eigen::Vector3d eye = object_from_camera.translation;
  ImageF pixels = to_linear_rgb(capture.image);
  capture.mask = ImageU8(pixels.width(), pixels.height(), 1, 255);
  for (int y = 0; y < pixels.height(); ++y)
    for (int x = 0; x < pixels.width(); ++x) {
      const Eigen::Vector3d ray = object_from_camera.rotation * *capture.camera.ray({double(x), double(y)});
      const Eigen::Vector3d p = eye - eye.z() / ray.z() * ray;
      if (!hidden(p.x(), p.y())) continue;
      capture.mask.at(x, y) = 0;
      Eigen::Map<Eigen::Vector3f>(pixels.pixel(x, y)) = Eigen::Vector3f(0, 8, 0);
    }
  capture.image = analytic::float_image(pixels);
  return capture;
}

/// Every image lacks the half of the square that lies beyond a line through a place near its middle.
std::vector<Capture> half_hidden(const Scene& scene, int count) {
  std::vector<Capture> images = captures(scene, eyes(count, kDistance, kLowest));
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> angle(0, 2 * M_PI), offset(-0.03, 0.03);
  for (Capture& image : images) {
    const double a = angle(engine), o = offset(engine);
    image = hide(image, [&](double x, double y) { return std::cos(a) * x + std::sin(a) * y > o; });
  }
  return images;
}

TEST(HiddenSurface, WhatAnOccluderHidesInSomeViewsIsTakenFromTheOthers) {
  // The little square floats above the large one and hides another part of it from every eye.
  const auto mesh = std::make_shared<Mesh>(joined(square_mesh(0.1f, 0, 8), square_mesh(0.025f, 0.04f, 2)));
  const Scene scene{analytic::nearest_of(analytic::square(0.1, 0), analytic::square(0.025, 0.04)),
                    analytic::diffuse(0.08)};
  SurfaceLightField model(mesh, plain_options());
  ingest_all(model, captures(scene, eyes(30, kDistance, kLowest)));
  const Comparison result = compare(*model.snapshot(), scene, unseen_eyes());
  EXPECT_GT(result.pixels, 10'000u);
  // At the occluder's rim a pixel's centre may fall on the other side of it than its ray at the mesh: none does here.
  EXPECT_LT(result.rms, 0.01);
  EXPECT_GT(result.darkest_ratio, 0.85) << "nothing goes black";
}

TEST(HiddenSurface, HalvesThatAreHiddenInEachViewAreCompletedToTheTruth) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.2)};
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, half_hidden(scene, 40));
  const Comparison result = compare(*model.snapshot(), scene, unseen_eyes());
  EXPECT_EQ(result.unseen, 0u);
  EXPECT_LT(result.rms, 0.02);
  EXPECT_GT(result.darkest_ratio, 0.8) << "nothing goes black";
  EXPECT_LT(result.rms, 0.25 * compare(*model.constant_colour(), scene, unseen_eyes()).rms);
}

TEST(HiddenSurface, WhatFewImagesShowIsImputedAndWhatNoneShowsUnseen) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.2)};
  SurfaceLightField model(object.mesh, plain_options());
  std::vector<Capture> images = captures(scene, eyes(12, kDistance, kLowest));
  // From left to right: shown by all, a stripe, narrower than a patch, that a third show, shown by none.
  for (std::size_t i = 0; i < images.size(); ++i)
    images[i] =
        hide(images[i], [&](double x, double) { return x > 0.05 || (i % 3 != 0 && std::abs(x - 0.025) < 0.008); });
  ingest_all(model, images);
  const PaintedView view =
      RayPainter(*object.mesh)
          .paint(*model.snapshot(), camera_at({0, 0, kDistance}), look_at({0, 0, kDistance}, {0, 0, 0}, {0, 1, 0}));
  const auto coverage_at = [&](double x) {
    const auto p = camera_at({0, 0, kDistance})
                       .project(look_at({0, 0, kDistance}, {0, 0, 0}, {0, 1, 0}) * Eigen::Vector3d(x, 0.03, 0));
    return view.coverage.at(static_cast<int>(std::lround(p->x())), static_cast<int>(std::lround(p->y())));
  };
  EXPECT_EQ(coverage_at(-0.06), kCoverageMeasured);
  EXPECT_EQ(coverage_at(0.018), kCoverageImputed);
  EXPECT_EQ(coverage_at(0.085), kCoverageUnseen);
}

TEST(SampleStates, TheShareOfTheImagesDecides) {
  EXPECT_EQ(shown_fraction(0, 7), 0);
  EXPECT_EQ(shown_fraction(1, 100'000), 1) << "shown once is not unseen";
  EXPECT_EQ(shown_fraction(5, 5), 255);
  EXPECT_EQ(sample_state(shown_fraction(0, 4)), SampleState::kUnseen);
  EXPECT_EQ(sample_state(shown_fraction(1, 4)), SampleState::kImputed);
  EXPECT_EQ(sample_state(shown_fraction(49, 100)), SampleState::kImputed);
  EXPECT_EQ(sample_state(shown_fraction(1, 2)), SampleState::kMeasured) << "half is enough";
  EXPECT_EQ(sample_state(shown_fraction(1, 1)), SampleState::kMeasured);
}

TEST(HiddenSurface, APlaceShownForTheFirstTimeTakesOnItsColourAtOnce) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.08)};
  const std::vector<Capture> images = captures(scene, eyes(20, kDistance, kLowest));
  SurfaceLightField model(object.mesh, plain_options());
  for (int i = 0; i < 10; ++i) ingest_all(model, {hide(images[i], [](double x, double) { return x > 0.007; })});
  const Comparison before = compare(*model.snapshot(), scene, unseen_eyes());
  EXPECT_GT(before.unseen, before.pixels / 3);
  EXPECT_GT(before.darkest_ratio, 0.8) << "no dark seam where the shown part ends";
  ingest_all(model, {images[10]});
  const Comparison after = compare(*model.snapshot(), scene, unseen_eyes());
  EXPECT_LT(after.unseen, before.unseen / 20);
  EXPECT_LT(after.rms, 0.012);
  EXPECT_GT(after.darkest_ratio, 0.85);
}

TEST(HiddenSurface, ViewDependenceOfAPlaceShownLateIsLearned) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.2)};
  const std::vector<Capture> images = captures(scene, eyes(40, kDistance, kLowest));
  SurfaceLightField model(object.mesh, plain_options());
  for (int i = 0; i < 20; ++i) ingest_all(model, {hide(images[i], [](double x, double) { return x > 0.007; })});
  ingest_all(model, {images.begin() + 20, images.end()});
  const Comparison result = compare(*model.snapshot(), scene, unseen_eyes());
  EXPECT_EQ(result.unseen, 0u);
  EXPECT_LT(result.rms, 0.02);
  EXPECT_GT(result.darkest_ratio, 0.8);
}

TEST(HiddenSurface, ASliverThatOnlyTheNeighbouringRingTookInIsNotDarkened) {
  // Every other image shows the left part, the others the right part; between them a gap that none shows. Patches over
  // the gap take in one part or both, each from other images: neither colour must be dimmed, nor what lies between.
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.2)};
  const std::vector<Capture> images = captures(scene, eyes(12, kDistance, kLowest));
  for (const double left : {0.004, 0.01, 0.014})
    for (const double right : {0.02, 0.025, 0.03, 0.035, 0.04, 0.045}) {
      SurfaceLightField model(object.mesh, plain_options());
      for (int i = 0; i < 12; ++i) {
        const auto hidden = [&](double x, double) { return i % 2 ? x > left : x < right; };
        ingest_all(model, {hide(images[i], hidden)});
      }
      const Comparison result = compare(*model.snapshot(), scene, unseen_eyes());
      EXPECT_GT(result.unseen, 100u) << left << ' ' << right;
      EXPECT_GT(result.darkest_ratio, 0.8) << left << ' ' << right;
      EXPECT_LT(result.worst, 0.1) << left << ' ' << right;
    }
}

void expect_filled(const Object& object) {
  const Scene scene{object.surface, analytic::encoded([](const Eigen::Vector3d&, const Eigen::Vector3d&) {
                      return Eigen::Vector3d(0.3, 0.5, 0.7);
                    })};
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures(scene, {{0.5, 0, 0}, {0.45, 0.2, 0.05}}));
  const std::shared_ptr<const Appearance> light_field = fill_unseen(*model.light_field_snapshot());
  for (const auto& filled : {light_field, model.constant_colour()}) {
    std::size_t guessed = 0;
    for (const double side : {1.0, -1.0}) {
      const auto shader = filled->shader_for({{side, 0, 0}});
      for (std::uint32_t t = 0; t < object.mesh->triangles.size(); ++t) {
        const SurfaceSample sample = shader->shade(t, 0.3f, 0.3f);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(srgb_encode(sample.rgb[c]), 0.3 + 0.2 * c, 4e-3);
        guessed += sample.state == SampleState::kUnseen;
        if (object.mesh->corner(t, 0).x() < -0.03f) EXPECT_EQ(sample.state, SampleState::kUnseen);
      }
    }
    EXPECT_GT(guessed, object.mesh->triangles.size() / 2);
  }
}

TEST(HiddenSurface, TheFilledSnapshotHasNoHolesAndSaysWhatItGuessed) {
  expect_filled(sphere_object());
}

TEST(HiddenSurface, AGuessSpreadsOverVerticesOfOnePlace) {
  const Object object = sphere_object();
  expect_filled({std::make_shared<Mesh>(triangle_soup(*object.mesh)), object.surface});
}

TEST(HiddenSurface, APartThatTouchesNothingSeenGetsAGuess) {
  const Object object = sphere_object();
  Mesh inside = *object.mesh;  // where no image shows it
  for (Eigen::Vector3f& vertex : inside.vertices) vertex *= 0.3f;
  expect_filled({std::make_shared<Mesh>(joined(*object.mesh, inside)), object.surface});
}

}  // namespace
}  // namespace sheen
