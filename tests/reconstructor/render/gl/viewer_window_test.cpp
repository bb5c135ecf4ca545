// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/viewer_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <thread>

#include "common/base/errors.h"
#include "reconstructor/models/surface_light_field/gl/light_field_renderer.h"
#include "reconstructor/render/gl/gl_objects.h"
#include "reconstructor/render/gl/picture_drawer.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/reconstructor/render/gl/hidden_window.h"

namespace sheen {
namespace {

TEST_F(Window, IncrementalUploadEqualsAFullOne) {
  const SyntheticLightField light_field({});
  // Small buffers and a small budget: several buffers, several calls, growth, and maps that change their size.
  ASSERT_TRUE(open({.texels_per_update = 20000, .max_buffer_texels = 1000000}));
  draw(light_field.snapshot());
  const ImageU8 incremental = draw(light_field.with_changed_patches(3, 9));
  const ImageU8 and_back = draw(light_field.snapshot());
  ASSERT_TRUE(open({}));
  EXPECT_EQ(largest_difference(incremental, draw(light_field.with_changed_patches(3, 9))), 0);
  EXPECT_EQ(largest_difference(and_back, draw(light_field.snapshot())), 0);
  EXPECT_GT(largest_difference(and_back, incremental), 10) << "the change can be seen at all";
}

TEST_F(Window, WhilePatchesAreOnTheirWayThePictureStaysWhole) {
  const SyntheticLightField light_field({});
  LightFieldRenderer renderer({.texels_per_update = 50000});
  RenderTarget target(kWidth, kHeight, 1);
  const auto render = [&](const Viewpoint& view) {
    target.clear({0, 0, 0});
    renderer.draw(view, {{0, 0, kWidth, kHeight}, kHeight}, SurfaceShading::kAppearance);
    target.resolve();
    return target.read();
  };
  OrbitCamera orbit;
  orbit.frame(bounding_sphere(light_field.snapshot()->mesh()));
  const Viewpoint view = orbit.viewpoint(kWidth, kHeight);
  while (!renderer.update(light_field.snapshot())) {
  }
  const ImageU8 before = render(view);
  // Every patch gets other maps and other coefficients that make the same picture; maps of the one with coefficients of
  // the other would not. Then some get maps of other sides, and all the first coefficients.
  for (const auto& next : {light_field.with_other_bases(), light_field.with_finer_maps(7), light_field.snapshot()}) {
    bool complete = false;
    int calls = 0;
    for (; !complete; ++calls) {
      complete = renderer.update(next);
      EXPECT_LE(largest_difference(render(view), before), 1) << "after call " << calls;
    }
    EXPECT_GT(calls, 3) << "more than one call's worth";
  }
}

/// Mean difference of two pictures where `b` is moved by (dx, dy), after a blur that leaves nothing of single pixels.
double blurred_difference(const ImageU8& a, const ImageU8& b, int dx, int dy) {
  constexpr int kReach = 4;
  double sum = 0;
  int count = 0;
  for (int y = 20; y + 20 < kHeight; y += 3)
    for (int x = 20; x + 20 < kWidth; x += 3) {
      int difference = 0;
      for (int v = -kReach; v <= kReach; ++v)
        for (int u = -kReach; u <= kReach; ++u) difference += a.at(x + u, y + v, 1) - b.at(x + dx + u, y + dy + v, 1);
      sum += std::abs(difference) / double((2 * kReach + 1) * (2 * kReach + 1));
      ++count;
    }
  return sum / count;
}

TEST_F(Window, ACoarsePictureIsTheFineOneInPlaceAndColour) {
  const auto snapshot = SyntheticLightField({}).snapshot();
  for (const ViewMode mode : {ViewMode::kAppearance, ViewMode::kSplit}) {
    ASSERT_TRUE(open({}));  // the first picture of all is a coarse one
    window_->controls().mode = mode;
    const double pixel = window_->pacer().frame().pixel;
    ASSERT_GE(pixel, 2);
    const ImageU8 coarse = window_->draw_soon(state_of(snapshot)), fine = draw(snapshot);
    const double apart = blurred_difference(coarse, fine, 0, 0);
    EXPECT_LT(apart, 1) << "grey levels of 255";
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
      EXPECT_GT(blurred_difference(coarse, fine, dx, dy), 1.1 * apart) << "not moved by a pixel: " << dx << " " << dy;
  }
}

TEST_F(Window, PiecesMakeTheSamePictureAsTheWhole) {
  const ViewerState state = state_of(SyntheticLightField({}).snapshot());
  ViewControls controls;
  controls.frame(*state.snapshot);
  for (const ViewMode mode : {ViewMode::kAppearance, ViewMode::kHeuristic, ViewMode::kSplit}) {
    controls.mode = mode;
    PictureDrawer drawer(surface_light_field_kind(), {}, 4);
    drawer.resize(kWidth, kHeight);
    while (!drawer.update(state)) {
    }
    int pieces = 1;
    while (!drawer.draw_piece(state, controls)) ++pieces;
    EXPECT_GT(pieces, 3) << "while it is not known what a picture takes";
    const ImageU8 in_pieces = drawer.target().read();
    drawer.draw_fine(state, controls);
    EXPECT_EQ(largest_difference(in_pieces, drawer.target().read()), 0) << to_string(mode);
  }
}

TEST_F(Window, FullGraphicsMemoryShortensPatchesInsteadOfLosingThem) {
  const SyntheticLightField light_field({.unseen = 0});
  LightFieldRenderer renderer({.max_buffer_texels = 200000});
  while (!renderer.update(light_field.snapshot())) {
  }
  EXPECT_GT(renderer.shortened_patches(), 0u);
  EXPECT_LE(renderer.texels_used(), 4 * 200000u);
  const SyntheticLightField small({.around = 24, .across = 8, .unseen = 0});
  while (!renderer.update(small.snapshot())) {
  }
  EXPECT_EQ(renderer.shortened_patches(), 0u) << "another model finds the room of the first";
}

TEST_F(Window, EveryModeDrawsWhatItShould) {
  ViewerState state = state_of(SyntheticLightField({}).snapshot());
  state.capture = synthetic_capture({0.22, -0.1, 0.16});
  state.figures = CaptureFigures{.frames_received = 152,
                                 .frames_accepted = 121,
                                 .frames_held_out = 11,
                                 .frames_refused = {{"too_near", 22}, {"motion_blur", 9}},
                                 .images_per_s = 5.3,
                                 .residual = 0.041,
                                 .predicted_psnr_db = 29.4,
                                 .held_out_psnr_db = 31.2,
                                 .held_out_ssim = 0.941};
  state.link = TrackerLink::kStale;
  state.next_view = NextView{{-0.1, 0.2, 0.15}, "sparse directions"};
  ViewControls& controls = window_->controls();
  controls.panels = true;
  std::vector<ImageU8> pictures;
  for (const ViewMode mode : {ViewMode::kAppearance, ViewMode::kHeuristic, ViewMode::kSplit, ViewMode::kCamera}) {
    controls.mode = mode;
    pictures.push_back(window_->draw_once(state));
    for (std::size_t i = 0; i + 1 < pictures.size(); ++i)
      EXPECT_GT(largest_difference(pictures[i], pictures.back()), 60) << to_string(mode);
  }
  controls.mode = ViewMode::kAppearance;
  const auto differs = [&](bool ViewControls::*option) {
    controls.*option = true;
    const ImageU8 picture = window_->draw_once(state);
    controls.*option = false;
    return largest_difference(picture, pictures[0]) > 60;
  };
  EXPECT_TRUE(differs(&ViewControls::help));
  EXPECT_TRUE(differs(&ViewControls::details));
  EXPECT_TRUE(differs(&ViewControls::follow));
  EXPECT_TRUE(differs(&ViewControls::states));
  EXPECT_FALSE(differs(&ViewControls::reasons)) << "the light field has none";
  state.figures->trade = {.effort_level = 2, .effort_levels = 6, .image_ms = 40, .budget_ms = 33};
  EXPECT_GT(largest_difference(window_->draw_once(state), pictures[0]), 60) << "a budget that is not kept is seen";
}

TEST_F(Window, SaysWhereNoPhotographIsFrom) {
  const Object object = square_object();
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures({object.surface, analytic::two_terms(0.1)}, {{0.02, 0, 0.5}, {0.05, 0.02, 0.5}}));
  ViewerState state;
  state.snapshot = model.snapshot();
  ViewControls& controls = window_->controls();
  controls.frame(state.snapshot->shared_mesh());
  controls.panels = true;
  const auto words = [&](const Eigen::Vector3d& eye) {  // amber pixels
    controls.orbit.place(eye);
    const ImageU8 picture = window_->draw_once(state);
    int count = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        count += picture.at(x, y, 0) > 200 && std::abs(picture.at(x, y, 1) - 190) < 40 && picture.at(x, y, 2) < 110;
    return count;
  };
  EXPECT_EQ(words({0.03, 0.01, 0.5}), 0);
  EXPECT_GT(words({0.35, 0.1, 0.35}), 100);
}

TEST_F(Window, BeforeTheFirstImageTheMeshIsThereInGrey) {
  const auto model = SyntheticLightField({}).snapshot();
  const auto empty =
      std::make_shared<SurfaceLightFieldSnapshot>(model->shared_mesh(), model->shared_maps(), model->shared_shapes(),
                                                  SurfaceLightFieldSnapshot::Patches(model->patches().size()), 0);
  const ImageU8 picture = draw(empty);
  const Viewpoint view = window_->controls().orbit.viewpoint(kWidth, kHeight);
  const RayPainter painter(model->mesh());
  const std::vector<Hit> hits = painter.cast(view.camera, view.camera_from_object);
  const ImageU8 mask = interior(hits, 0.02);
  const Eigen::Vector3f eye = view.eye().cast<float>();
  int looked_at = 0, off = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      if (!mask.at(x, y)) continue;
      const auto& corners = model->mesh().triangles[hits[y * kWidth + x].triangle];
      const auto& v = model->mesh().vertices;
      const Eigen::Vector3f normal = (v[corners[1]] - v[corners[0]]).cross(v[corners[2]] - v[corners[0]]).normalized();
      const float lit = 0.72f * (0.25f + 0.75f * std::abs(normal.dot((eye - v[corners[0]]).normalized())));
      EXPECT_EQ(picture.at(x, y, 0), picture.at(x, y, 1));
      EXPECT_EQ(picture.at(x, y, 0), picture.at(x, y, 2));
      off += std::abs(picture.at(x, y, 0) - 255 * lit) > 12;
      ++looked_at;
    }
  EXPECT_LT(off, looked_at / 20) << "but for pixels on the edges of triangles";
  EXPECT_GT(looked_at, 30000);
}

TEST_F(Window, WhatThePersonWaitsForHasABar) {
  window_->controls().panels = true;
  const auto green = [this](double fraction) {
    ViewerState state = state_of(SyntheticLightField({.around = 24, .across = 8}).snapshot());
    state.work = WorkInHand{"SAVING the model: part 13 of 52", fraction};
    const ImageU8 picture = window_->draw_once(state);
    int n = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        n += picture.at(x, y, 0) == 70 && picture.at(x, y, 1) == 192 && picture.at(x, y, 2) == 122;
    return n;
  };
  EXPECT_EQ(green(0), 0);
  const int quarter = green(0.25);
  EXPECT_GT(quarter, 200);
  EXPECT_NEAR(green(1), 4 * quarter, 0.05 * 4 * quarter);
}

TEST(ViewControls, AModelIsLookedAtAnewWhenItsColoursComeUnlessSomebodyHasMovedIt) {
  const Object object = sphere_object();
  const std::vector<Eigen::Vector3d> eyes = {{0.4, 0, 0.2}, {0, 0.4, 0.2}, {-0.4, 0, 0.2}, {0, -0.4, 0.2}};
  const auto radiance = analytic::encoded([](const Eigen::Vector3d& p, const Eigen::Vector3d&) {
    return Eigen::Vector3d(Eigen::Vector3d::Constant(0.4 - 3 * p.y()));  // bright on the side of -y
  });
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures({object.surface, radiance}, eyes));
  const auto whole = std::dynamic_pointer_cast<const SurfaceLightFieldSnapshot>(model.snapshot());
  const SurfaceLightFieldSnapshot grey(whole->shared_mesh(), whole->shared_maps(), whole->shared_shapes(),
                                       SurfaceLightFieldSnapshot::Patches(whole->patches().size()), 0, {},
                                       whole->cameras());
  for (const bool moved : {false, true}) {
    ViewControls controls;
    controls.frame(grey);
    if (moved) controls.orbit.orbit(0.1, 0);
    const Viewpoint before = controls.orbit.viewpoint(kWidth, kHeight);
    controls.frame(*whole);
    const Viewpoint after = controls.orbit.viewpoint(kWidth, kHeight);
    EXPECT_EQ(after == before, moved);
    controls.reset();
    EXPECT_LT(controls.orbit.viewpoint(kWidth, kHeight).eye().normalized().y(), -0.8) << "it opens in the best light";
  }
}

TEST_F(Window, PanelsLieOverThePictureAndDoNotChangeIt) {
  const ViewerState state = state_of(SyntheticLightField({.around = 24, .across = 8}).snapshot());
  const ImageU8 clean = window_->draw_once(state);
  window_->controls().panels = true;
  const ImageU8 with_panels = window_->draw_once(state);
  EXPECT_GT(largest_difference(with_panels, clean), 60);
  for (int y = 2 * kHeight / 5; y < 3 * kHeight / 5; ++y)
    EXPECT_TRUE(std::equal(clean.row(y), clean.row(y) + 3 * kWidth, with_panels.row(y))) << y;
  window_->controls().panels = false;
  EXPECT_EQ(largest_difference(window_->draw_once(state), clean), 0);
}

TEST_F(Window, TheGroundIsWhatWasChosen) {
  const auto snapshot = SyntheticLightField({.around = 24, .across = 8}).snapshot();
  Ground& ground = window_->controls().ground;
  do {
    const ImageU8 picture = draw(snapshot);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(picture.at(0, 0, c), 255 * color_of(ground)[c], 1);
    ground = next(ground);
  } while (ground != Ground::kDark);
}

TEST_F(Window, TheMeshsOutlineLiesOverTheImageThroughTheLens) {
  ViewerState state = state_of(SyntheticLightField({}).snapshot());
  state.capture = synthetic_capture({0.22, -0.1, 0.16});
  window_->controls().mode = ViewMode::kCamera;
  const ImageU8 with_mesh = window_->draw_once(state);
  state.snapshot = nullptr;
  const ImageU8 without = window_->draw_once(state);
  // The painter casts rays through the lens: the picture may have changed round what it hits, and nowhere else.
  const auto capture = synthetic_capture({0.22, -0.1, 0.16});
  const auto mesh = SyntheticLightField({}).snapshot()->shared_mesh();
  const Camera camera = capture->camera.scaled(kWidth, kHeight);
  const std::vector<Hit> hits = RayPainter(*mesh).cast(camera, capture->pose.camera_from_object);
  std::vector<Eigen::Vector2d> axes;  // they are as long as the mesh is large, and stick out of it
  for (int axis = 0; axis < 3; ++axis)
    for (double length = 0; length < 0.1; length += 0.001)
      if (const auto p = camera.project(capture->pose.camera_from_object * (length * Eigen::Vector3d::Unit(axis))))
        axes.push_back(*p);
  const auto near_an_axis = [&](int x, int y) {
    return std::any_of(axes.begin(), axes.end(),
                       [&](const auto& p) { return (p - Eigen::Vector2d(x, y)).norm() < 20; });
  };
  const auto changed = [&](int x, int y) {
    return !std::equal(&with_mesh.at(x, y, 0), &with_mesh.at(x, y, 0) + 3, &without.at(x, y, 0));
  };
  constexpr int kReach = 4;  // pixels: half the outline's width, and what interpolation of the lens leaves
  int inside = 0, outside = 0, border = 0, drawn = 0;
  for (int y = kReach; y + kReach < kHeight; ++y)
    for (int x = kReach; x + kReach < kWidth; ++x) {
      if (near_an_axis(x, y)) continue;
      int of_object = 0, nearby = 0, marked = 0;
      for (int dy = -kReach; dy <= kReach; ++dy)
        for (int dx = -kReach; dx <= kReach; ++dx) {
          of_object += bool(hits[std::size_t((y + dy) * kWidth + x + dx)]);
          marked += changed(x + dx, y + dy);
          ++nearby;
        }
      if (of_object == nearby) inside += changed(x, y);
      if (of_object == 0) outside += changed(x, y);
      const bool hit = bool(hits[std::size_t(y * kWidth + x)]);
      if (hit && !hits[std::size_t(y * kWidth + x + 1)]) {
        ++border;
        drawn += marked > 0;
      }
    }
  EXPECT_EQ(inside, 0) << "the object is seen as the camera has it";
  EXPECT_EQ(outside, 0);
  ASSERT_GT(border, 100);
  EXPECT_EQ(drawn, border) << "all round";
}

TEST_F(Window, EmptyStatesAndOddOnesAreDrawn) {
  window_->controls().panels = true;
  window_->controls().follow = true;
  for (const ViewMode mode : {ViewMode::kAppearance, ViewMode::kHeuristic, ViewMode::kSplit, ViewMode::kCamera}) {
    window_->controls().mode = mode;
    EXPECT_NO_THROW(window_->draw_once({}));
    EXPECT_NO_THROW(draw(SyntheticLightField({.unseen = 1}).snapshot()));
    ViewerState unposed;
    auto capture = std::make_shared<Capture>(*synthetic_capture({0.2, 0, 0.2}));
    capture->pose.status = PoseStatus::kNoTags;
    capture->tags.clear();
    unposed.capture = capture;
    unposed.message = "pas de pose \xc3\xa0 voir";
    EXPECT_NO_THROW(window_->draw_once(unposed));
    ViewerState inside = state_of(SyntheticLightField({}).snapshot());
    inside.capture = synthetic_capture({0.06, 0.001, 0.001});  // the eye in the middle of the object
    EXPECT_NO_THROW(window_->draw_once(inside));
  }
}

TEST_F(Window, RunShowsTheLatestStateAndStopsWhenAsked) {
  ViewerFeed feed;
  std::stop_source stop;
  const auto snapshot = SyntheticLightField({.around = 24, .across = 8}).snapshot();
  std::jthread loop([&] {
    for (int i = 0; i < 20; ++i) {
      feed.publish(state_of(snapshot));
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    stop.request_stop();
  });
  EXPECT_NO_THROW(window_->run(feed, stop.get_token()));
  EXPECT_EQ(feed.latest()->snapshot, snapshot);
}

TEST(NoDisplay, IsSaidClearly) {
  const char* display = std::getenv("DISPLAY");
  const std::string kept = display ? display : "";
  unsetenv("DISPLAY");
  try {
    ViewerWindow window(surface_light_field_kind(), {.visible = false});
    ADD_FAILURE() << "a window without a display";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("xvfb-run"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("sheen-reconstructor render"), std::string::npos) << error.what();
  }
  if (display) setenv("DISPLAY", kept.c_str(), 1);
}

}  // namespace
}  // namespace sheen
