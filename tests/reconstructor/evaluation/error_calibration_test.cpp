// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/evaluation/error_calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace sheen {
namespace {

TEST(ErrorCalibration, KnownDifferencesGiveAKnownOffsetAndInterval) {
  // The mean is -1. Without each in turn the others' mean is -0.75, -0.875, -1, -1.125, -1.25: off by 1.25, 0.625, 0,
  // 0.625, 1.25. Of five views the rank is ceil(0.8 * 6) = 5.
  const std::vector<double> differences{-2, -1.5, -1, -0.5, 0};
  const ErrorCalibration calibration = calibrate(differences);
  EXPECT_EQ(calibration.views, 5u);
  EXPECT_DOUBLE_EQ(calibration.offset_db, -1);
  EXPECT_DOUBLE_EQ(calibration.half_width_db, 1.25);
  const CalibratedPsnr psnr = calibration.apply(30);
  EXPECT_DOUBLE_EQ(psnr.db, 29);
  EXPECT_DOUBLE_EQ(psnr.low_db, 27.75);
  EXPECT_DOUBLE_EQ(psnr.high_db, 30.25);
}

TEST(ErrorCalibration, OfNineViewsOneDoesNotMakeTheInterval) {
  std::vector<double> differences(9, 0.5);
  differences[3] = -40;
  EXPECT_DOUBLE_EQ(calibrate(differences).offset_db, -4);
  EXPECT_DOUBLE_EQ(calibrate(differences).half_width_db, 4.5 * 9 / 8) << "rank 8 of 9: by the eight, not by the one";
}

TEST(ErrorCalibration, DoesNotDependOnTheOrderOfTheViews) {
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal(-1, 0.7);
  std::vector<double> differences(11);
  for (double& difference : differences) difference = normal(generator);
  const ErrorCalibration calibration = calibrate(differences);
  for (int k = 0; k < 5; ++k) {
    std::shuffle(differences.begin(), differences.end(), generator);
    EXPECT_EQ(calibrate(differences).offset_db, calibration.offset_db);
    EXPECT_EQ(calibrate(differences).half_width_db, calibration.half_width_db);
  }
}

TEST(ErrorCalibration, OfTooFewViewsSaysNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(calibrate({}).known());
  EXPECT_FALSE(calibrate(std::vector<double>{1, 2, 3}).known());
  EXPECT_TRUE(std::isnan(calibrate(std::vector<double>{1, 2, 3}).apply(30).db));
  EXPECT_FALSE(calibrate(std::vector<double>{1, 2, 3, nan, infinity}).known()) << "views without a figure do not count";
  EXPECT_TRUE(calibrate(std::vector<double>{1, 2, 3, nan, 4}).known());
}

TEST(ErrorCalibration, HoldsAboutAsManyOfTheViewsToComeAsItSays) {
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal(-1.3, 0.8);
  std::student_t_distribution<double> heavy(3);
  constexpr int kDraws = 4000;
  for (const int views : {4, 6, 9, 14, 19}) {
    for (const bool tails : {false, true}) {
      const auto draw = [&] { return tails ? heavy(generator) : normal(generator); };
      int inside = 0;
      for (int k = 0; k < kDraws; ++k) {
        std::vector<double> differences(static_cast<std::size_t>(views));
        for (double& difference : differences) difference = draw();
        const CalibratedPsnr psnr = calibrate(differences).apply(30);
        const double measured = 30 + draw();
        inside += psnr.low_db <= measured && measured <= psnr.high_db;
      }
      EXPECT_GT(inside, 0.7 * kDraws) << views << " views" << (tails ? ", heavy tails" : "");
      EXPECT_LT(inside, 0.9 * kDraws) << views << " views" << (tails ? ", heavy tails" : "");
    }
  }
}

TEST(CalibrationCheck, AViewIsCalibratedByTheOthersAlone) {
  const std::vector<double> predicted{30, 31, 32, 33, 34}, measured{28, 29.5, 31, 32.5, 20};
  const CalibrationCheck check = check_calibration(predicted, measured);
  ASSERT_TRUE(check.known());
  EXPECT_DOUBLE_EQ(check.predicted_db, 32);
  EXPECT_DOUBLE_EQ(check.measured_db, 28.2);
  // Differences -2, -1.5, -1, -0.5, -14: without the last one their mean is -1.25.
  const PredictedView& last = check.views.back();
  EXPECT_EQ(last.by_the_others.views, 4u);
  EXPECT_DOUBLE_EQ(last.calibrated().db, 34 - 1.25);
  EXPECT_FALSE(last.inside());
  EXPECT_DOUBLE_EQ(check.coverage, 0.8);
}

TEST(CalibrationCheck, OfFewerViewsThanCalibrateGivesThePredictionAlone) {
  const std::vector<double> predicted{30, 31, 32, 33}, measured{29, 30, 31, 32};
  const CalibrationCheck check = check_calibration(predicted, measured);
  EXPECT_FALSE(check.known());
  EXPECT_DOUBLE_EQ(check.predicted_db - check.measured_db, 1);
  EXPECT_TRUE(std::isnan(check.calibrated_db));
  EXPECT_TRUE(std::isnan(check.coverage));
  EXPECT_FALSE(check_calibration({}, {}).known());
}

}  // namespace
}  // namespace sheen
