// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/view_collector.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/tracker/calibration/synthetic_target.h"
#include "tracker/calibration/next_view.h"
#include "tracker/calibration/view_advice.h"

namespace sheen {
namespace {

constexpr ImageSize kSize{800, 600};
constexpr double kNoise_px = 0.1;

const LensFit& lens() {
  return *find_lens_fit("brown-k3");
}

class NextViewsTest : public ::testing::Test {
 protected:
  TargetView seen_from(const Rigid3& pose) {
    std::normal_distribution<double> noise(0, kNoise_px);
    TargetView view{"view", {}};
    for (std::size_t i = 0; i < target_.points.size(); ++i)
      if (const auto pixel = camera_.project(pose * target_.points[i]); pixel && camera_.contains(*pixel))
        view.sightings.push_back({static_cast<int>(i), *pixel + Eigen::Vector2d(noise(rng_), noise(rng_))});
    return view;
  }
  Calibration calibrated(const std::vector<TargetView>& views) const {
    return calibrate(target_.points, views, kSize, lens());
  }
  /// At the same noise, so that two can be compared.
  static double uncertainty(const Calibration& calibration) {
    return projection_uncertainty(calibration.camera, calibration.covariance).rms() / calibration.noise_px;
  }

  std::mt19937 rng_{7};
  const Camera camera_ = testing::ordinary_camera();
  const CalibrationTarget target_ = parse_target("charuco:9x7:25mm:18mm");
};

TEST_F(NextViewsTest, ForetellWhatAViewLeavesOfTheUncertainty) {
  for (int trial = 0; trial < 5; ++trial) {
    std::vector<TargetView> views = testing::simulated_views(camera_, target_.points, 6, kNoise_px, rng_);
    const Calibration before = calibrated(views);
    const Rigid3 pose = testing::random_target_pose(camera_, target_.points, rng_);
    views.push_back(seen_from(pose));
    const double foretold = NextViews(before, target_).uncertainty_left(views.back(), pose);
    EXPECT_NEAR(foretold, uncertainty(calibrated(views)) / uncertainty(before), 0.1);
    EXPECT_LT(foretold, 1);
  }
}

TEST_F(NextViewsTest, ViewsThatAreAskedForTeachMoreThanRandomOnes) {
  const std::vector<TargetView> begin = testing::simulated_views(camera_, target_.points, 5, kNoise_px, rng_);
  std::vector<TargetView> asked = begin, random = begin;
  for (int i = 0; i < 8; ++i) {
    const WantedView next = NextViews(calibrated(asked), target_).best();
    EXPECT_LT(next.uncertainty_left, 1);
    EXPECT_NE(next.in_words.find("target "), std::string::npos);
    asked.push_back(seen_from(next.camera_from_target));
    random.push_back(testing::simulated_views(camera_, target_.points, 1, kNoise_px, rng_).front());
  }
  EXPECT_LT(uncertainty(calibrated(asked)), 0.8 * uncertainty(calibrated(random)));
}

TEST_F(NextViewsTest, AWholeChessboardIsAskedFor) {
  const CalibrationTarget board = parse_target("chessboard:9x6:25mm");
  const Calibration so_far = calibrated(testing::simulated_views(camera_, target_.points, 6, kNoise_px, rng_));
  const WantedView next = NextViews(so_far, board).best();
  for (const Eigen::Vector3d& point : board.points) {
    const auto pixel = so_far.camera.project(next.camera_from_target * point);
    ASSERT_TRUE(pixel);
    EXPECT_TRUE(so_far.camera.contains(*pixel));
  }
}

class ViewCollectorTest : public NextViewsTest {
 protected:
  /// As a camera of 10 frames/s shows it for so many frames.
  SeenView show(const TargetView& view, int frames = 2, double exposure_s = 0) {
    SeenView seen = SeenView::kNoTarget;
    for (int i = 0; i < frames && seen != SeenView::kKept; ++i) seen = collector_.see(view, time_ += 0.1, exposure_s);
    return seen;
  }
  static TargetView shifted(TargetView view, double by) {
    for (TargetSighting& s : view.sightings) s.pixel.x() += by;
    return view;
  }
  ViewCollector collector_{target_, kSize, lens()};
  double time_ = 0;
};

TEST_F(ViewCollectorTest, KeepsWhatIsStillAndNew) {
  const auto views = testing::simulated_views(camera_, target_.points, 2, kNoise_px, rng_);
  EXPECT_EQ(show({}), SeenView::kNoTarget);
  EXPECT_EQ(show(views[0], 1), SeenView::kMoving) << "one frame does not tell";
  EXPECT_EQ(show(views[0], 1), SeenView::kKept);
  EXPECT_EQ(show(views[0]), SeenView::kNothingNew);
  EXPECT_EQ(show(shifted(views[0], 5), 1), SeenView::kMoving);
  EXPECT_EQ(show(views[1], 1), SeenView::kMoving);
  EXPECT_EQ(show(shifted(views[1], 3), 1, 0.001), SeenView::kKept) << "0.03 pixels during the exposure";
  EXPECT_EQ(collector_.views().size(), 2u);
  EXPECT_EQ(collector_.study(), nullptr);
  EXPECT_NE(collector_.next_view(), "");
}

TEST_F(ViewCollectorTest, EndsWithACameraThatNothingIsMissingOf) {
  int shown = 0;
  for (; !collector_.complete() && shown < 200; ++shown)
    show(testing::simulated_views(camera_, target_.points, 1, kNoise_px, rng_).front());
  ASSERT_TRUE(collector_.complete());
  EXPECT_EQ(collector_.next_view(), "");
  EXPECT_LT(collector_.views().size(), 40u);
  EXPECT_LT(collector_.views().size(), static_cast<std::size_t>(shown)) << "not all of them added anything";
  ASSERT_NE(collector_.study(), nullptr);
  EXPECT_EQ(refusal(*collector_.study(), advise(*collector_.study())), "");
  EXPECT_LT(projection_difference(camera_, collector_.study()->calibration.camera).worst(),
            3 * collector_.study()->uncertainty.worst());
}

}  // namespace
}  // namespace sheen
