// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/support/expect_error.h"
#include "tests/tracker/calibration/synthetic_target.h"
#include "tracker/calibration/calibration_study.h"
#include "tracker/calibration/target.h"
#include "tracker/calibration/view_advice.h"

namespace sheen {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr ImageSize kSize{800, 600};

std::vector<Eigen::Vector3d> chessboard() {
  return parse_target("chessboard:9x6:25mm").points;
}

TEST(LensFunctions, AgreeWithTheCameraThatIsUsedElsewhere) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const Camera& camera : {testing::ordinary_camera(), testing::fisheye_camera()}) {
    const Intrinsics intrinsics = intrinsics_of(camera);
    EXPECT_EQ(with_intrinsics(camera, intrinsics), camera);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d point(0.5 * unit(rng), 0.4 * unit(rng), 1);
      Eigen::Vector2d pixel;
      ASSERT_TRUE(project_point(camera.lens, intrinsics.data(), point.data(), pixel.data()));
      EXPECT_LT((pixel - *camera.project(point)).norm(), 1e-9);
    }
  }
}

TEST(Calibration, RecoversEveryModelExactlyFromExactCorners) {
  for (const LensFit& fit : lens_fits()) {
    SCOPED_TRACE(fit.name);
    std::mt19937 rng(2);
    Camera truth = fit.lens == LensModel::kFisheye ? testing::fisheye_camera() : testing::ordinary_camera();
    Intrinsics values = intrinsics_of(truth);
    for (int i = 0; i < kIntrinsics; ++i)
      if (!fit.free[i]) values[i] = i == 1 ? 1 : 0;
    if (fit.free[1]) values[1] = 1.01;
    truth = with_intrinsics(truth, values);
    const auto target = chessboard();
    const Calibration found = calibrate(target, testing::simulated_views(truth, target, 12, 0, rng), kSize, fit);
    EXPECT_NEAR(found.camera.fx, truth.fx, 1e-4);
    EXPECT_NEAR(found.camera.fy, truth.fy, 1e-4);
    EXPECT_LT(projection_difference(truth, found.camera).worst(), 1e-3);
    EXPECT_LT(found.rms_all_px, 1e-6);
  }
}

/// Normalised estimation errors squared of 100 calibrations: e^T C^-1 e has the mean of its degrees of freedom, and
/// the mean of 100 of them a standard deviation of sqrt(2 n / 100). Bounds are four of these.
TEST(Calibration, ErrsByAsMuchAsItSays) {
  constexpr int kRuns = 100;
  for (const char* name : {"brown-k3", "fisheye"}) {
    SCOPED_TRACE(name);
    const LensFit& fit = *find_lens_fit(name);
    const Camera truth = fit.lens == LensModel::kFisheye ? testing::fisheye_camera() : testing::ordinary_camera();
    const auto target = chessboard();
    std::mt19937 rng(3);
    double intrinsics_nees = 0, noise = 0, worst_ratio = 0;
    std::vector<double> pixel_nees(projection_covariance(truth, IntrinsicsCovariance::Identity()).size(), 0.0);
    for (int run = 0; run < kRuns; ++run) {
      const auto views = testing::simulated_views(truth, target, 15, 0.1, rng);
      const Calibration found = calibrate(target, views, kSize, fit);
      noise += found.noise_px / kRuns;
      const Intrinsics error = intrinsics_of(found.camera) - intrinsics_of(truth);
      std::vector<int> free;
      for (int i = 0; i < kIntrinsics; ++i)
        if (fit.free[i]) free.push_back(i);
      const Eigen::VectorXd e = error(free);
      const Eigen::MatrixXd covariance = found.covariance(free, free);
      intrinsics_nees += e.dot(covariance.ldlt().solve(e)) / kRuns;
      const auto shifts = projection_shift(found.camera, truth);
      const auto covariances = projection_covariance(found.camera, found.covariance);
      for (std::size_t i = 0; i < shifts.size(); ++i)
        pixel_nees[i] += shifts[i].dot(covariances[i].inverse() * shifts[i]) / kRuns;
    }
    const double count = fit.parameters();
    EXPECT_NEAR(intrinsics_nees, count, 4 * std::sqrt(2 * count / kRuns));
    EXPECT_NEAR(noise, 0.1, 0.001);
    for (const double nees : pixel_nees) worst_ratio = std::max(worst_ratio, std::abs(nees - 2));
    // Hundreds of places, no two far apart independent: a bound of five for the worst of them.
    EXPECT_LT(worst_ratio, 5 * std::sqrt(2 * 2.0 / kRuns));
  }
}

TEST(Calibration, NamesCornersAndImagesThatAreWrong) {
  std::mt19937 rng(4);
  const Camera truth = testing::ordinary_camera();
  const auto target = chessboard();
  auto views = testing::simulated_views(truth, target, 14, 0.1, rng);
  views[3].sightings[17].pixel += Eigen::Vector2d(1.5, -1);
  views[8].sightings[40].pixel += Eigen::Vector2d(-40, 25);
  std::normal_distribution<double> noise(0, 3);  // a blurred image
  for (TargetSighting& s : views[5].sightings) s.pixel += Eigen::Vector2d(noise(rng), noise(rng));
  views.push_back({"empty.png", {}});
  const Calibration found = calibrate(target, views, kSize, *find_lens_fit("brown-k3"));
  for (std::size_t i = 0; i < found.views.size(); ++i) {
    SCOPED_TRACE(found.views[i].name);
    EXPECT_EQ(found.views[i].used, i != 5 && i != 14);
    if (i == 3 || i == 8)
      ASSERT_EQ(found.views[i].rejected.size(), 1u);
    else
      EXPECT_TRUE(found.views[i].rejected.empty());
  }
  EXPECT_EQ(found.views[3].rejected[0].point, 17);
  EXPECT_EQ(found.views[8].rejected[0].point, 40);
  EXPECT_NEAR(found.views[8].rejected[0].error_px, std::hypot(40, 25), 0.5);
  EXPECT_THAT(found.views[5].reason, HasSubstr("corners are off"));
  EXPECT_THAT(found.views[14].reason, HasSubstr("not found"));
  EXPECT_LT(projection_difference(truth, found.camera).centre(), 0.2);
  EXPECT_GT(found.rms_all_px, 2 * found.rms_px);
}

TEST(CalibrationStudy, ChoosesTheModelThatTheLensHas) {
  const auto target = chessboard();
  const auto chosen = [&](const Camera& truth) {
    std::mt19937 rng(5);
    const auto views = testing::simulated_views(truth, target, 20, 0.05, rng);
    return std::string(study_calibration(target, views, kSize, nullptr).calibration.fit->name);
  };
  Camera camera = testing::ordinary_camera();
  EXPECT_THAT(chosen(camera), HasSubstr("brown"));
  camera.distortion = {-0.2, 0.1, 0, 0, 0};
  EXPECT_EQ(chosen(camera), "radial");
  camera.distortion = {};
  EXPECT_EQ(chosen(camera), "pinhole");
  camera.fy *= 1.01;
  EXPECT_EQ(chosen(camera), "brown-k3-aspect");
  EXPECT_EQ(chosen(testing::fisheye_camera()), "fisheye");
}

TEST(CalibrationStudy, HalvesDifferAsMuchAsNoiseExplains) {
  const auto target = chessboard();
  std::mt19937 rng(6);
  double measured = 0, expected = 0;
  for (int run = 0; run < 8; ++run) {
    const auto views = testing::simulated_views(testing::ordinary_camera(), target, 20, 0.1, rng);
    const CalibrationStudy study = study_calibration(target, views, kSize, find_lens_fit("brown-k3"));
    ASSERT_TRUE(study.halves);
    measured += std::pow(study.halves->difference.rms(), 2);
    expected += std::pow(study.halves->expected_rms_px, 2);
    EXPECT_EQ(refusal(study, advise(study)), "");
  }
  EXPECT_NEAR(std::sqrt(measured / expected), 1, 0.35);
}

TEST(CalibrationStudy, KnowsATargetThatIsNotFlat) {
  const auto target = chessboard();
  auto bent = target;
  for (Eigen::Vector3d& p : bent) p.z() = 0.002 * std::pow((p.x() - 0.1) / 0.1, 2);  // 2 mm at its edges
  std::mt19937 rng(7);
  const auto views = testing::simulated_views(testing::ordinary_camera(), bent, 20, 0.02, rng);
  const CalibrationStudy study = study_calibration(target, views, kSize, find_lens_fit("brown-k3"));
  EXPECT_THAT(warnings(study), Contains(HasSubstr("mm out of its plane")));
  ASSERT_TRUE(study.shape);
  EXPECT_NEAR(study.shape->out_of_plane_m, 0.0013, 0.0002);  // of a parabola 2 mm high, after the plane that fits best
  EXPECT_NEAR(study.shape->rms_px, 0.02 * std::sqrt(2), 0.005);
  const CalibrationStudy flat =
      study_calibration(target, testing::simulated_views(testing::ordinary_camera(), target, 20, 0.02, rng), kSize,
                        find_lens_fit("brown"));
  EXPECT_THAT(warnings(flat), ::testing::IsEmpty());
  EXPECT_LT(flat.shape->out_of_plane_m, 0.0001);
}

CalibrationStudy study_of(const testing::TargetPoses& poses, int views, const char* lens = "brown") {
  std::mt19937 rng(8);
  const auto target = chessboard();
  return study_calibration(target, testing::simulated_views(testing::ordinary_camera(), target, views, 0.1, rng, poses),
                           kSize, find_lens_fit(lens));
}

TEST(CalibrationRefusal, SaysThatTiltIsMissing) {
  try {
    const CalibrationStudy study = study_of({.most_tilt_deg = 1.5}, 12);
    const std::string why = refusal(study, advise(study));
    EXPECT_THAT(why, HasSubstr("focal length is uncertain"));
    EXPECT_THAT(why, HasSubstr("right edge nearer"));
    EXPECT_THAT(why, HasSubstr("upper edge nearer"));
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("tilt the target"));
  }
}

TEST(CalibrationRefusal, SaysWhichPartOfTheImageIsMissing) {
  const CalibrationStudy study = study_of({.least_distance = 4, .most_distance = 5, .spread = 0.15}, 15, "brown-k3");
  const ViewAdvice advice = advise(study);
  EXPECT_THAT(advice.uncovered, Contains("bottom left"));
  const std::string why = refusal(study, advice);
  EXPECT_THAT(why, HasSubstr("bring the target into the part of the image where it was never seen: top left"));
}

TEST(CalibrationRefusal, SaysThatViewsAreTooFew) {
  const CalibrationStudy study = study_of({}, 4);
  EXPECT_THAT(refusal(study, advise(study)), HasSubstr("only 4 images can be used; a calibration needs 5"));
  expect_error<Error>([] { study_of({}, 2); }, {"only 2 images"});
}

TEST(CalibrationRefusal, KnowsATargetThatIsNotTheOneNamed) {
  std::mt19937 rng(9);
  const auto seen = parse_target("chessboard:9x6:25mm").points;
  const auto views = testing::simulated_views(testing::ordinary_camera(), seen, 12, 0.05, rng);
  auto named = seen;
  for (Eigen::Vector3d& p : named) p.y() *= 1.4;  // 25 mm wide, 35 mm high
  const auto complaint = [&]() -> std::string {
    try {
      const CalibrationStudy study = study_calibration(named, views, kSize, find_lens_fit("brown"));
      return refusal(study, advise(study));
    } catch (const Error& error) {
      return error.what();
    }
  };
  EXPECT_NE(complaint(), "");
}

}  // namespace
}  // namespace sheen
