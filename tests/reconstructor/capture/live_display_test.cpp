// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/live_display.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/image/jpeg.h"
#include "reconstructor/render/guess_marks.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

TEST(LiveDisplay, SaysWhetherImagesAreStillToCome) {
  const Mesh mesh = square_mesh(0.1f, 0, 1);
  LiveDisplay display({});
  const auto shown = [&](const LoopStatus& status) {
    display.publish_to_window(status);
    return display.feed().latest()->link;
  };
  LoopStatus status;
  EXPECT_EQ(shown(status), TrackerLink::kWaiting);
  status.links.resize(1);
  status.links[0].stats.ended = true;
  EXPECT_EQ(shown(status), TrackerLink::kEnded) << "not a saved model that is looked at";
}

TEST(LiveDisplay, BeforeTheFirstTrackerTheMeshIsShownAndHowToStartOne) {
  const auto mesh = std::make_shared<const Mesh>(sphere_mesh(0.1f, 2));
  Reconstruction nothing_yet(*mesh, SurfaceLightFieldOptions{});
  LiveDisplay display({.trackers = {{"tcp://127.0.0.1:7410", "sheen-tracker run"}}});
  display.observer().on_snapshot(nothing_yet.snapshot(), nothing_yet.shared_painter());
  const auto now = MonitorState::Clock::now();
  const MonitorState waiting = display.monitor_state({});
  EXPECT_EQ(capture_state(waiting, now, now), CaptureState::kWaiting);
  EXPECT_EQ(waiting.hint, "sheen-tracker run");
  EXPECT_EQ(waiting.next_view, "");
  ASSERT_TRUE(waiting.preview_jpeg);
  const ImageU8 picture = decode_jpeg(*waiting.preview_jpeg);
  EXPECT_GT(picture.at(picture.width() / 2, picture.height() / 2, 0), 100) << "the mesh, in grey";
  EXPECT_NEAR(picture.at(2, 2, 0), 28, 3) << "the ground of the window";
  display.publish_to_window({});
  EXPECT_EQ(display.feed().latest()->message, "start a tracker: sheen-tracker run");
  display.publish_to_window({}, {EndStage::kSaving, 3, 12});
  EXPECT_EQ(display.feed().latest()->message, "") << "nobody is waited for any more";

  LoopStatus status;
  status.links.resize(1);
  ReceiverStats& link = status.links[0].stats;
  link.connected = link.came = true;
  EXPECT_EQ(display.monitor_state(status).hint, "");
  link.tracker = {56, {{"motion_blur", 55}}, "too fast: motion blur"};
  EXPECT_EQ(display.monitor_state(status).tracker.trouble, "too fast: motion blur");
  EXPECT_EQ(display.monitor_state(status).tracker.refused.at("motion_blur"), 55u);
  display.publish_to_window(status);
  EXPECT_EQ(display.feed().latest()->trouble, "too fast: motion blur");
  EXPECT_EQ(display.feed().latest()->figures->tracker_judged, 56u);
  EXPECT_EQ(display.feed().latest()->message, "");
  status.mesh_look = MeshLook{24, 3, 12};
  display.publish_to_window(status);
  EXPECT_EQ(display.feed().latest()->message, "improving the mesh with 24 images: step 3 of 12");
  display.warn("the mesh stands elsewhere; run `sheen-tracker register`");
  display.publish_to_window(status);
  EXPECT_EQ(display.feed().latest()->message, "the mesh stands elsewhere; run `sheen-tracker register`");
  EXPECT_EQ(display.monitor_state(status).warnings.size(), 1u);
  link.connected = false;
  EXPECT_EQ(display.monitor_state(status).tracker.trouble, "") << "what was wrong when it was last heard of";
  EXPECT_EQ(capture_state(display.monitor_state(status), now, now), CaptureState::kDisconnected);
}

TEST(LiveDisplay, OneOfTwoTrackersIsStillToComeAndAnotherIsGone) {
  const Mesh mesh = square_mesh(0.1f, 0, 1);
  LiveDisplay display({.trackers = {{"tcp://a:1", "start a"}, {"tcp://b:1", "start b"}}});
  EXPECT_EQ(display.monitor_state({}).hint, "start a and start b");
  LoopStatus status;
  status.links = {{"tcp://a:1", {}}, {"tcp://b:1", {}}};
  ReceiverStats &a = status.links[0].stats, &b = status.links[1].stats;
  a.connected = a.came = true;
  EXPECT_EQ(display.monitor_state(status).hint, "start b");
  display.publish_to_window(status);
  EXPECT_EQ(display.feed().latest()->message, "start a tracker: start b");
  b.came = true;
  display.publish_to_window(status);
  EXPECT_EQ(display.feed().latest()->message, "tcp://b:1: the tracker is gone");
  const auto now = MonitorState::Clock::now();
  EXPECT_EQ(capture_state(display.monitor_state(status), now, now), CaptureState::kDisconnected);
  EXPECT_EQ(display.monitor_state(status).links[1].name, "tracker 2");
  b.ended = true;
  EXPECT_EQ(capture_state(display.monitor_state(status), now, now), CaptureState::kWaiting) << "it is not gone";
}

TEST(LiveDisplay, CamerasAreShownInTurnWithoutAFlicker) {
  const Object object = square_object();
  auto images = captures({object.surface, analytic::two_terms(0.1)}, {{0.02, 0, 0.5}, {0.05, 0.02, 0.5}});
  images[0].calibration_hash = "left";
  images[1].calibration_hash = "right";
  LiveDisplay display({});
  const LoopObserver observer = display.observer();
  for (const Capture& image : {images[0], images[1], images[0], images[1]}) {
    observer.on_capture(image);
    display.publish_to_window({});
    EXPECT_EQ(display.feed().latest()->capture->calibration_hash, "left");
  }
}

TEST(LiveDisplay, ThePageSaysWhereItsPictureIsOfAPlaceWithoutPhotographs) {
  const Object object = square_object();
  const auto images =
      captures({object.surface, analytic::two_terms(0.1)}, {{0.02, 0, 0.5}, {0.05, 0.02, 0.5}, {0.35, 0, 0.35}});
  Reconstruction reconstruction(*object.mesh, plain_options());
  LiveDisplay display({});
  LoopObserver observer = display.observer();
  for (const Capture& image : {images[0], images[1]}) reconstruction.ingest(image);
  observer.on_capture(images[2]);
  observer.on_snapshot(reconstruction.snapshot(), reconstruction.shared_painter());
  EXPECT_THAT(display.monitor_state({}).preview_note,
              ::testing::MatchesRegex("no photograph from here: the nearest is [34][0-9] degrees away"));
  reconstruction.ingest(images[2]);
  observer.on_snapshot(reconstruction.snapshot(), reconstruction.shared_painter());
  EXPECT_EQ(display.monitor_state({}).preview_note, "");
}

TEST(LiveDisplay, ThePagesPicturesShowTheObjectLargeAndItsOutlineInTheCamerasImage) {
  const Object object = square_object();
  const auto images = captures({object.surface, analytic::two_terms(0.1)}, {{0.02, 0, 0.5}, {0.05, 0.02, 0.5}});
  Reconstruction reconstruction(*object.mesh, plain_options());
  LiveDisplay display({});
  LoopObserver observer = display.observer();
  EXPECT_FALSE(display.monitor_state({}).surface);
  for (const Capture& image : images) reconstruction.ingest(image);
  observer.on_snapshot(reconstruction.snapshot(), reconstruction.shared_painter());
  observer.on_capture(images[1]);
  const MonitorState state = display.monitor_state({});
  ASSERT_TRUE(state.surface && state.preview_jpeg && state.camera_jpeg);
  EXPECT_NEAR(state.surface->seen, 0.96, 0.03) << "the images cut the square a little";

  const ImageU8 model = decode_jpeg(*state.preview_jpeg), camera = decode_jpeg(*state.camera_jpeg);
  const auto is_ground = [&](int x, int y) {
    return std::abs(model.at(x, y, 0) - 29) < 6 && std::abs(model.at(x, y, 2) - 36) < 6;
  };
  int on_object = 0;
  for (int x = 0; x < model.width(); ++x) on_object += !is_ground(x, model.height() / 2);
  EXPECT_GT(on_object, model.width() / 3) << "a square fills the height of its circle by 1 / sqrt 2, less the rim";
  EXPECT_TRUE(is_ground(2, 2));

  Capture lost = images[1];
  lost.pose.status = PoseStatus::kNoTags;
  observer.on_capture(lost);
  const ImageU8 plain = decode_jpeg(*display.monitor_state({}).camera_jpeg);

  // What is drawn is where a pixel's ray meets the square's edge, to a block of JPEG's colours, and nowhere else.
  const Camera thumbnail = images[1].camera.scaled(camera.width(), camera.height());
  const Rigid3& pose = images[1].pose.camera_from_object;
  const Eigen::Vector3d eye = camera_centre(pose);
  int drawn = 0;
  for (int y = 0; y < camera.height(); ++y)
    for (int x = 0; x < camera.width(); ++x) {
      if (std::abs(camera.at(x, y, 1) - plain.at(x, y, 1)) < 40) continue;
      ++drawn;
      const auto ray = thumbnail.ray({x, y});
      ASSERT_TRUE(ray);
      const Eigen::Vector3d along = pose.rotation.conjugate() * *ray;
      const Eigen::Vector3d at = eye - eye.z() / along.z() * along;
      EXPECT_NEAR(at.head<2>().cwiseAbs().maxCoeff(), 0.1, 0.01) << x << ", " << y;
    }
  EXPECT_GT(drawn, camera.width() / 2);
}

TEST(LiveDisplay, ThePageShowsFromWhatAFoundShapeIsKnown) {
  Mesh mesh = sphere_mesh(0.1f, 3);
  LiveDisplay given({}), found({});
  const auto show = [&](LiveDisplay& display) {
    Reconstruction nothing_yet(mesh, SurfaceLightFieldOptions{});
    display.observer().on_snapshot(nothing_yet.snapshot(), nothing_yet.shared_painter());
    return display.monitor_state({});
  };
  const MonitorState without = show(given);
  EXPECT_FALSE(without.shape);
  EXPECT_FALSE(without.shape_jpeg);

  mesh.evidence.assign(mesh.vertices.size(), ShapeEvidence::kGuessed);
  const MonitorState with = show(found);
  ASSERT_TRUE(with.shape && with.shape_jpeg);
  EXPECT_EQ(with.shape->guessed, 1);
  EXPECT_EQ(with.shape->seen, 0);
  const ImageU8 picture = decode_jpeg(*with.shape_jpeg);
  const int x = picture.width() / 2, y = picture.height() / 2;
  const Eigen::Vector3f guess = 255 * evidence_color(ShapeEvidence::kGuessed);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(picture.at(x, y, c), guess[c], 25) << "faces the eye";
  EXPECT_NEAR(picture.at(2, 2, 0), 28, 3) << "the ground of the window";
}

TEST(LiveDisplay, BeforeAModelThePageShowsTheCamera) {
  const Object object = square_object();
  const Capture image = captures({object.surface, analytic::two_terms(0.1)}, {{0.02, 0, 0.5}}).front();
  const LiveDisplay::Names names{.trackers = {{"tcp://a:1", "start a"}}};
  const MonitorState waiting = state_before_first(names, {}, nullptr, "");
  EXPECT_EQ(waiting.hint, "start a");
  EXPECT_FALSE(waiting.camera_jpeg);
  const MonitorState looking = state_before_first(names, {}, &image, "The shape is being found.");
  EXPECT_EQ(looking.doing, "The shape is being found.");
  ASSERT_TRUE(looking.camera_jpeg);
  EXPECT_EQ(decode_jpeg(*looking.camera_jpeg).width(), 480);
}

TEST(LiveDisplay, ThePageSaysInWhichDirectionTheNextImageIs) {
  const Object object = square_object();
  const auto images =
      captures({object.surface, analytic::two_terms(0.1)}, {{0.02, 0, 0.5}, {0.05, 0.02, 0.5}, {0, 0.04, 0.5}});
  Reconstruction reconstruction(*object.mesh, plain_options());
  LiveDisplay display({});
  LoopObserver observer = display.observer();
  for (const Capture& image : images) {
    observer.on_capture(image);
    reconstruction.ingest(image);
  }
  observer.on_snapshot(reconstruction.snapshot(), reconstruction.shared_painter());
  EXPECT_THAT(display.monitor_state({}).next_view,
              ::testing::MatchesRegex("move [0-9]+ degrees (to the (left|right)(, [0-9]+ (up|down))?|up|down): .+"));

  LoopStatus behind;
  behind.journaled = 45;
  behind.ingested = 3;
  behind.images_per_s = 5;
  EXPECT_EQ(display.monitor_state(behind).next_view, "") << "42 images wait: what is missing is not known";
  EXPECT_FALSE(display.monitor_state(behind).well_known);
  display.publish_to_window(behind);
  EXPECT_FALSE(display.feed().latest()->next_view);
  display.publish_to_window({});
  ASSERT_TRUE(display.feed().latest()->next_view);

  // Whoever is on the way there is not sent elsewhere by the next image.
  const Eigen::Vector3d asked = display.feed().latest()->next_view->eye;
  reconstruction.ingest(captures({object.surface, analytic::two_terms(0.1)}, {{0.1, 0.1, 0.5}}).front());
  observer.on_snapshot(reconstruction.snapshot(), reconstruction.shared_painter());
  display.publish_to_window({});
  EXPECT_EQ(display.feed().latest()->next_view->eye, asked);
}

TEST(LiveDisplay, SaysNoNumbersOfAnEndThatHasNone) {
  LiveDisplay display({});
  display.publish_to_window({}, {EndStage::kSaving, 0, 0});
  EXPECT_EQ(display.feed().latest()->work->what, "The model is being saved");
}

TEST(LiveDisplay, WhatIsReceivedIsUsedRefusedTakenBackOrWaits) {
  const Mesh mesh = square_mesh(0.1f, 0, 1);
  LiveDisplay display({});
  LoopStatus status;
  status.journaled = 20;
  status.ingested = 12;
  status.counts = {.received = 12, .accepted = 7, .held_out = 1, .refused = {{"no_pose", 3}}, .withdrawn = 1};
  display.publish_to_window(status);
  const CaptureFigures shown = *display.feed().latest()->figures;
  EXPECT_EQ(shown.frames_received, 20u);
  EXPECT_EQ(shown.frames_waiting, 8u);
  EXPECT_EQ(shown.frames_received,
            shown.frames_accepted + shown.frames_refused.at("no_pose") + shown.frames_withdrawn + shown.frames_waiting);
  const MonitorState page = display.monitor_state(status);
  EXPECT_EQ(page.received, 20u);
  EXPECT_EQ(page.received, page.accepted + page.held_out + page.refused.at("no_pose") + page.withdrawn + page.waiting);
}

TEST(LiveDisplay, FinishingSavingAndJudgingAreStatesWithABar) {
  const Mesh mesh = square_mesh(0.1f, 0, 1);
  LiveDisplay display({});
  const auto long_ago = MonitorState::Clock::now() - std::chrono::minutes(1);
  const auto expect = [&](EndStage stage, CaptureState state, const std::string& word) {
    const EndProgress end{stage, 3, 12};
    display.publish_to_window({}, end);
    const auto window = display.feed().latest();
    ASSERT_TRUE(window->work);
    EXPECT_EQ(window->work->what.substr(0, word.size()), word);
    EXPECT_EQ(window->work->fraction, 0.25);
    EXPECT_EQ(window->link, TrackerLink::kEnded) << "not a tracker that fell silent";
    MonitorState page = display.monitor_state({}, end);
    page.last_frame = long_ago;
    EXPECT_EQ(capture_state(page, MonitorState::Clock::now(), MonitorState::Clock::now()), state);
    EXPECT_EQ(page.ending->done, 3u);
    EXPECT_EQ(page.ending->total, 12u);
  };
  expect(EndStage::kFinishing, CaptureState::kFinishing, "The last images are being added: image 3 of 12");
  expect(EndStage::kSaving, CaptureState::kSaving, "The model is being saved");
  expect(EndStage::kJudging, CaptureState::kJudging, "The model is compared");
  display.publish_to_window({});
  EXPECT_FALSE(display.feed().latest()->work);
}

}  // namespace
}  // namespace sheen
