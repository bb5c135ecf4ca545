// SPDX-License-Identifier: Apache-2.0
// The window draws what the ray painter paints.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/image/color.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/reconstructor/render/gl/hidden_window.h"

namespace sheen {
namespace {

TEST_F(Window, AgreesWithTheRayPainter) {
  const SyntheticLightField light_field({});
  const auto snapshot = light_field.snapshot();
  const RayPainter painter(snapshot->mesh());
  ViewControls& controls = window_->controls();
  controls.frame(snapshot->shared_mesh());
  for (const double azimuth : {0.0, 1.9, 4.0}) {
    controls.orbit.place({0.25 * std::cos(azimuth), 0.25 * std::sin(azimuth), 0.12 - 0.05 * azimuth});
    const Viewpoint view = controls.orbit.viewpoint(kWidth, kHeight);
    const PaintedView truth = painter.paint(*snapshot, view.camera, view.camera_from_object);
    const ImageU8 mask = interior(painter.cast(view.camera, view.camera_from_object), 0.02);
    const ImageU8 expected = to_srgb8(truth.beauty), actual = draw(snapshot);

    double sum = 0;
    int count = 0, unseen = 0, guessed = 0, striped = 0, largest = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        if (!mask.at(x, y)) continue;
        if (truth.coverage.at(x, y) == kCoverageUnseen) {
          const bool empty = truth.beauty.at(x, y, 0) == 0;  // no ring at all: the window is dark there
          int change = 0;
          for (int c = 0; c < 3; ++c) change = std::max(change, std::abs(actual.at(x, y, c) - expected.at(x, y, c)));
          ++(empty ? unseen : guessed);
          striped += !empty && change > 8;
          if (empty) {
            EXPECT_LT(actual.at(x, y, 0), 70);
          }
          continue;
        }
        for (int c = 0; c < 3; ++c) {
          const int difference = std::abs(actual.at(x, y, c) - expected.at(x, y, c));
          sum += difference;
          largest = std::max(largest, difference);
          ++count;
        }
      }
    ASSERT_GT(count, 30000);
    EXPECT_LT(sum / count, 0.1) << "grey levels of 255";
    EXPECT_LE(largest, 2) << "grey levels of 255";
    RecordProperty("mean_difference_millilevels", static_cast<int>(1000 * sum / count));
    if (azimuth == 0.0) {
      EXPECT_GT(unseen, 500) << "the part that no image reached is in this view";
    }
    if (azimuth == 4.0) {
      EXPECT_GT(guessed, 500);
      EXPECT_GT(striped, 0.3 * guessed) << "guesses are marked";
      EXPECT_LT(striped, 0.7 * guessed) << "and still shown";
    }
  }
}

TEST_F(Window, TheStatesAreThePainters) {
  const SyntheticLightField light_field({});
  const auto snapshot = light_field.snapshot();
  const RayPainter painter(snapshot->mesh());
  ViewControls& controls = window_->controls();
  controls.frame(snapshot->shared_mesh());
  controls.orbit.place({0.02, -0.02, 0.35});
  const Viewpoint view = controls.orbit.viewpoint(kWidth, kHeight);
  const PaintedView truth = painter.paint(*snapshot, view.camera, view.camera_from_object);
  const ImageU8 mask = interior(painter.cast(view.camera, view.camera_from_object), 0.02);
  const ImageU8 plain = draw(snapshot);
  controls.states = true;
  const ImageU8 tinted = draw(snapshot);
  std::map<int, int> pixels, changed;  // by coverage
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      if (!mask.at(x, y)) continue;
      int change = 0;
      for (int c = 0; c < 3; ++c) change = std::max(change, std::abs(tinted.at(x, y, c) - plain.at(x, y, c)));
      ++pixels[truth.coverage.at(x, y)];
      changed[truth.coverage.at(x, y)] += change > 10;
    }
  for (const int coverage : {kCoverageUnseen, kCoverageImputed, kCoverageMeasured})
    ASSERT_GT(pixels[coverage], 500) << coverage;
  EXPECT_EQ(changed[kCoverageMeasured], 0);
  EXPECT_GT(changed[kCoverageImputed], 0.98 * pixels[kCoverageImputed]);
  EXPECT_GT(changed[kCoverageUnseen], 0.98 * pixels[kCoverageUnseen]);
}

TEST_F(Window, TheExposureScalesLightAsThePaintersDoes) {
  const SyntheticLightField light_field({});
  const auto snapshot = light_field.with_exposure(0.6f);
  const RayPainter painter(snapshot->mesh());
  window_->controls().frame(snapshot->shared_mesh());
  window_->controls().orbit.place({0.25, 0, 0.12});
  const Viewpoint view = window_->controls().orbit.viewpoint(kWidth, kHeight);
  const PaintedView truth = painter.paint(*snapshot, view.camera, view.camera_from_object);
  const ImageU8 mask = interior(painter.cast(view.camera, view.camera_from_object), 0.02);
  const ImageU8 expected = to_srgb8(truth.beauty), actual = draw(snapshot);
  int largest = 0, count = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      if (!mask.at(x, y) || truth.coverage.at(x, y) != 255) continue;
      ++count;
      for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(actual.at(x, y, c) - expected.at(x, y, c)));
    }
  ASSERT_GT(count, 10000);
  EXPECT_LE(largest, 2) << "grey levels of 255";
}

TEST_F(Window, TheHeuristicIsThePaintersFromGreenToRed) {
  const auto snapshot = SyntheticLightField({}).snapshot();
  const RayPainter painter(snapshot->mesh());
  ViewControls& controls = window_->controls();
  controls.mode = ViewMode::kHeuristic;
  const ImageU8 picture = draw(snapshot);
  const Viewpoint view = controls.orbit.viewpoint(kWidth, kHeight);
  const PaintedView truth = painter.paint(*snapshot, view.camera, view.camera_from_object);
  const ImageU8 mask = interior(painter.cast(view.camera, view.camera_from_object), 0.02);
  double sum = 0, lowest = 1, highest = 0;
  int count = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      if (!mask.at(x, y)) continue;
      // Shape darkens all channels alike, so that the need is that of the colour in the same direction.
      const Eigen::Vector3f shown =
          Eigen::Vector3f(picture.at(x, y, 0), picture.at(x, y, 1), picture.at(x, y, 2)).normalized();
      double need = 0, nearest = -1;
      for (int i = 0; i <= 200; ++i) {
        const double alike = shown.dot(need_color(static_cast<float>(i) / 200).normalized());
        if (alike <= nearest) continue;
        nearest = alike;
        need = i / 200.0;
      }
      EXPECT_GT(nearest, 0.9999) << "a colour of the scale";
      sum += std::abs(need - truth.heuristic.at(x, y));
      lowest = std::min<double>(lowest, truth.heuristic.at(x, y));
      highest = std::max<double>(highest, truth.heuristic.at(x, y));
      ++count;
    }
  ASSERT_GT(count, 10000);
  EXPECT_LT(lowest, 0.5);
  EXPECT_GT(highest, 0.8);
  EXPECT_LT(sum / count, 0.01);
}

TEST_F(Window, WhatTheSceneRequiredIsInItsColours) {
  const auto snapshot = SyntheticLightField({}).snapshot();
  const RayPainter painter(snapshot->mesh());
  ViewControls& controls = window_->controls();
  for (const ViewMode mode : {ViewMode::kRank, ViewMode::kResolution, ViewMode::kBytes}) {
    controls.mode = mode;
    const ImageU8 picture = draw(snapshot);
    const Viewpoint view = controls.orbit.viewpoint(kWidth, kHeight);
    const std::vector<Hit> hits = painter.cast(view.camera, view.camera_from_object);
    const ImageU8 mask = interior(hits, 0.02);
    const DemandMap truth(*snapshot, *demand_of(mode));
    int count = 0, off = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Hit& hit = hits[static_cast<std::size_t>(y * kWidth + x)];
        if (!mask.at(x, y) || truth.levels()[hit.triangle] < 0) continue;
        // Shape darkens all channels alike, to four fifths at most.
        const Eigen::Vector3f colour = 255 * demand_colour(truth.levels()[hit.triangle]);
        const Eigen::Vector3f shown(picture.at(x, y, 0), picture.at(x, y, 1), picture.at(x, y, 2));
        const float shape = shown.dot(colour) / colour.squaredNorm();
        ++count;
        off += shape < 0.77f || shape > 1.03f || (shown - shape * colour).cwiseAbs().maxCoeff() > 2;
      }
    EXPECT_GT(count, 10000) << to_string(mode);
    EXPECT_LT(off, 0.02 * count) << to_string(mode) << ": only where another triangle begins";
  }
}

TEST_F(Window, AFoundShapeIsInTheColoursOfItsEvidence) {
  const auto without = SyntheticLightField({}).snapshot();
  const auto guessed = SyntheticLightField({.evidence = {ShapeEvidence::kGuessed}}).snapshot();
  ViewControls& controls = window_->controls();
  controls.mode = ViewMode::kShape;
  const auto in_colour = [&](const std::shared_ptr<const SurfaceLightFieldSnapshot>& snapshot,
                             const Eigen::Vector3f& colour) {
    const ImageU8 picture = draw(snapshot);
    const Viewpoint view = controls.orbit.viewpoint(kWidth, kHeight);
    const std::vector<Hit> hits = RayPainter(snapshot->mesh()).cast(view.camera, view.camera_from_object);
    const ImageU8 mask = interior(hits, 0.02);
    int count = 0, off = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        if (!mask.at(x, y)) continue;
        const Eigen::Vector3f shown(picture.at(x, y, 0), picture.at(x, y, 1), picture.at(x, y, 2));
        ++count;
        off += shown.norm() > 0 && shown.normalized().dot(colour.normalized()) > 0.999f ? 0 : 1;
      }
    EXPECT_GT(count, 10000);
    EXPECT_EQ(off, 0);
  };
  in_colour(guessed, evidence_color(ShapeEvidence::kGuessed));
  in_colour(without, Eigen::Vector3f::Ones());  // a mesh that was given is grey
}

TEST_F(Window, TheInsideIsStripedGreyAsInTheRayPainter) {
  const SyntheticLightField light_field({.unseen = 0});
  const auto snapshot = light_field.snapshot();
  ViewControls& controls = window_->controls();
  controls.frame(snapshot->shared_mesh());
  controls.orbit.place({0.06, 0, 0});  // inside the tube of the ring
  const Viewpoint view = controls.orbit.viewpoint(kWidth, kHeight);
  const PaintedView truth = RayPainter(snapshot->mesh()).paint(*snapshot, view.camera, view.camera_from_object);
  const ImageU8 expected = to_srgb8(truth.beauty), actual = draw(snapshot);
  int backs = 0, striped = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_EQ(truth.coverage.at(x, y), kCoverageUnseen);
      ASSERT_EQ(expected.at(x, y, 1), 89) << "no pattern";
      int change = 0;
      for (int c = 0; c < 3; ++c) change = std::max(change, std::abs(actual.at(x, y, c) - expected.at(x, y, c)));
      striped += change > 8;
      ++backs;
    }
  EXPECT_GT(striped, 0.3 * backs) << "guesses are marked";
  EXPECT_LT(striped, 0.7 * backs) << "and have the painter's colour between the stripes";
}

}  // namespace
}  // namespace sheen
