// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/stage_survey.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "tests/support/expect_error.h"
#include "tests/tracker/synthetic_stage.h"
#include "tracker/calibration/survey_judgement.h"

namespace sheen {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A stage as it was printed, as it stands, and images of how it stands.
struct Scene {
  StageLayout printed = make_stage({.tag_m = 0.05});
  StageLayout truth = printed;
  Camera camera = testing::stage_camera();
  std::vector<SurveyImage> images;

  StageTag& tag(int id) { return truth.tags[std::size_t(printed.find(id) - printed.tags.data())]; }
  Eigen::Vector3d middle(int id) const {
    const auto& c = truth.find(id)->corners_object;
    return (c[0] + c[1] + c[2] + c[3]) / 4;
  }
  MeasuredLength length(double error_m = 0, double uncertainty_m = 1e-4) const {
    return {0, 8, (middle(8) - middle(0)).norm() + error_m, uncertainty_m};
  }
  void take(int count, double noise_px, std::mt19937& rng) {
    for (int i = 0; i < count; ++i) {
      images.push_back({"image" + std::to_string(images.size()) + ".png",
                        testing::exact_observations(camera, truth, testing::random_stage_pose(rng))});
      testing::add_corner_noise(images.back().tags, noise_px, rng);
    }
  }
  void move(int id, const Eigen::Isometry3d& about_its_middle) {
    const Eigen::Vector3d centre = middle(id);
    for (Eigen::Vector3d& corner : tag(id).corners_object) corner = centre + about_its_middle * (corner - centre);
  }
};

std::vector<SurveyFinding> findings_of(const Scene& scene, const Camera& camera) {
  return judge_survey(survey_stage(camera, scene.printed, scene.images, scene.length()), scene.printed, 0);
}

Eigen::VectorXd corners_of(const StageLayout& stage) {
  Eigen::VectorXd all(12 * Eigen::Index(stage.tags.size()));
  Eigen::Index at = 0;
  for (const StageTag& tag : stage.tags)
    for (const Eigen::Vector3d& corner : tag.corners_object) {
      all.segment<3>(at) = corner;
      at += 3;
    }
  return all;
}

TEST(MeasuredLength, IsReadAsItIsWritten) {
  const MeasuredLength length = parse_measured_length("tag 3 to tag 17: 200mm");
  EXPECT_EQ(length.from_tag, 3);
  EXPECT_EQ(length.to_tag, 17);
  EXPECT_DOUBLE_EQ(length.metres, 0.2);
  EXPECT_DOUBLE_EQ(parse_measured_length("tag 0 to tag 1: 20cm +- 0.1mm").uncertainty_m, 1e-4);
  for (const char* wrong : {"", "3 to 7: 200mm", "tag 3 to tag 7", "tag 3 to tag 7: 200", "tag 3 to tag 3: 200mm",
                            "tag 3 to tag 7: 200mm +- ", "tag 3 to tag 7: -2mm"})
    expect_error<ConfigError>([&] { parse_measured_length(wrong); }, {"--length", "tag 3 to tag 7: 200mm"});
}

TEST(StageSurvey, FindsTheTrueStageFromExactCorners) {
  std::mt19937 rng(1);
  Scene scene;
  std::normal_distribution<double> off(0, 0.1e-3);  // CAPTURE: tags misplaced by a tenth of a millimetre
  for (StageTag& tag : scene.truth.tags) {
    const Eigen::Vector3d step(off(rng), off(rng), off(rng));
    for (Eigen::Vector3d& corner : tag.corners_object) corner += step;
  }
  scene.take(12, 0, rng);
  const StageSurvey survey = survey_stage(scene.camera, scene.printed, scene.images, scene.length());
  EXPECT_LT(survey.rms_px, 1e-6);
  ASSERT_EQ(survey.stage.tags.size(), scene.truth.tags.size());
  std::vector<Eigen::Vector3d> found, truth;
  for (std::size_t i = 0; i < survey.stage.tags.size(); ++i)
    for (int c = 0; c < 4; ++c) {
      found.push_back(survey.stage.tags[i].corners_object[c]);
      truth.push_back(scene.truth.tags[i].corners_object[c]);
    }
  const Similarity truth_from_found = fit_similarity(found, truth);
  EXPECT_NEAR(truth_from_found.scale, 1, 1e-7);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_LT((truth_from_found * found[i] - truth[i]).norm(), 1e-8);
  EXPECT_LT(truth_from_found.translation.norm(), 1e-4);  // its frame is that of the sheet
  EXPECT_THAT(judge_survey(survey, scene.printed, 0), IsEmpty());
}

/// 100 surveys with noise in the corners and in the length: each corner's e^T C^-1 e has the mean 3, that of the length
/// the mean 1; means of 100 lie within four of their standard deviations, the worst corner's within five.
TEST(StageSurvey, ErrsByAsMuchAsItSays) {
  constexpr int kRuns = 100;
  constexpr double kNoise_px = 0.05, kRuler_m = 2e-4;
  std::mt19937 rng(2);
  std::normal_distribution<double> unit(0, 1);
  Scene scene;
  const std::size_t corners = 4 * scene.truth.tags.size();
  std::vector<double> nees(corners, 0.0);
  double scale_nees = 0, all = 0;
  for (int run = 0; run < kRuns; ++run) {
    scene.images.clear();
    scene.take(10, kNoise_px, rng);
    const StageSurvey survey =
        survey_stage(scene.camera, scene.printed, scene.images, scene.length(kRuler_m * unit(rng), kRuler_m));
    ASSERT_EQ(survey.stage.tags.size(), scene.truth.tags.size());
    const Eigen::VectorXd error = corners_of(survey.stage) - corners_of(scene.truth);
    for (std::size_t i = 0; i < corners; ++i) {
      const Eigen::Vector3d e = error.segment<3>(3 * Eigen::Index(i));
      const Eigen::Matrix3d covariance = survey.covariance.block<3, 3>(3 * Eigen::Index(i), 3 * Eigen::Index(i));
      nees[i] += e.dot(covariance.ldlt().solve(e)) / kRuns;
      all += e.dot(covariance.ldlt().solve(e)) / (kRuns * double(corners));
    }
    scale_nees += std::pow((survey.scale - 1) / survey.scale_uncertainty, 2) / kRuns;
    EXPECT_NEAR(survey.noise_px, kNoise_px, 0.005);
  }
  EXPECT_NEAR(scale_nees, 1, 4 * std::sqrt(2.0 / kRuns));
  EXPECT_NEAR(all, 3, 4 * std::sqrt(2 * 3.0 / kRuns));  // corners of one survey are correlated
  for (const double one : nees) EXPECT_NEAR(one, 3, 5 * std::sqrt(2 * 3.0 / kRuns));
}

TEST(StageSurvey, NamesAWrongPrintScale) {
  std::mt19937 rng(3);
  Scene scene;
  for (StageTag& tag : scene.truth.tags)
    for (Eigen::Vector3d& corner : tag.corners_object) corner *= 0.97;
  scene.take(12, 0.05, rng);
  const auto findings = findings_of(scene, scene.camera);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].fault, SurveyFault::kPrintScale);
  EXPECT_THAT(findings[0].text, HasSubstr("97.0"));
}

TEST(StageSurvey, NamesAPrintThatIsStretched) {
  std::mt19937 rng(4);
  Scene scene;
  for (StageTag& tag : scene.truth.tags)
    for (Eigen::Vector3d& corner : tag.corners_object) corner.y() *= 1.004;
  scene.take(12, 0.05, rng);
  const auto findings = findings_of(scene, scene.camera);
  ASSERT_EQ(findings.size(), 2u);  // the length runs along both, so that the scale is off, too; no tag is to blame
  EXPECT_EQ(findings[0].fault, SurveyFault::kPrintScale);
  EXPECT_EQ(findings[1].fault, SurveyFault::kStretched);
  EXPECT_THAT(findings[1].text, HasSubstr("0.40 % longer along y than along x"));
}

TEST(StageSurvey, NamesTagsThatWereMovedAndTilted) {
  std::mt19937 rng(5);
  Scene scene;
  scene.move(5, Eigen::Isometry3d(Eigen::Translation3d(1.5e-3, -1e-3, 0)));
  scene.move(11, Eigen::Isometry3d(Eigen::AngleAxisd(4 * M_PI / 180, Eigen::Vector3d(0.6, 0.8, 0))));
  scene.take(12, 0.05, rng);
  const StageSurvey survey = survey_stage(scene.camera, scene.printed, scene.images, scene.length());
  const auto findings = judge_survey(survey, scene.printed, 0);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].fault, SurveyFault::kMovedTag);
  EXPECT_EQ(findings[0].tag, 5);
  const double aside = std::hypot(1.5e-3, 1e-3);
  EXPECT_NEAR(survey.tags[5].shift_m.norm(), aside, 0.05e-3);
  EXPECT_EQ(findings[1].fault, SurveyFault::kTiltedTag);
  EXPECT_EQ(findings[1].tag, 11);
  EXPECT_THAT(findings[1].text, HasSubstr("4.0 degrees"));
  EXPECT_LT((corners_of(survey.stage) - corners_of(scene.truth)).cwiseAbs().maxCoeff(), 0.1e-3);  // and knows better
}

TEST(StageSurvey, NamesATagThatMovedBetweenTheImages) {
  std::mt19937 rng(6);
  Scene scene;
  scene.take(14, 0.05, rng);
  scene.move(7, Eigen::Isometry3d(Eigen::Translation3d(0, 2e-3, 0)));
  scene.take(5, 0.05, rng);
  const StageSurvey survey = survey_stage(scene.camera, scene.printed, scene.images, scene.length());
  EXPECT_EQ(survey.stage.find(7), nullptr);
  const auto findings = judge_survey(survey, scene.printed, 0);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].fault, SurveyFault::kUnsteadyTag);
  EXPECT_EQ(findings[0].tag, 7);
  std::size_t seen = 0, seen_later = 0;
  for (std::size_t i = 0; i < scene.images.size(); ++i)
    for (const TagObservation& tag : scene.images[i].tags)
      if (tag.id == 7) {
        ++seen;
        seen_later += i >= 14;
      }
  EXPECT_THAT(findings[0].text, HasSubstr(std::to_string(seen_later) + " of " + std::to_string(seen) + " images"));
}

TEST(StageSurvey, NamesAFocalLengthThatIsWrong) {
  std::mt19937 rng(7);
  Scene scene;
  scene.take(15, 0.05, rng);
  for (const double factor : {0.98, 1.005}) {
    Camera wrong = scene.camera;
    wrong.fx *= factor;
    wrong.fy *= factor;
    const auto findings = findings_of(scene, wrong);
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_EQ(findings[0].fault, SurveyFault::kFocalLength);
    EXPECT_THAT(findings[0].text, HasSubstr(factor < 1 ? "2.0" : "0.5"));
    EXPECT_THAT(findings[0].text, HasSubstr(factor < 1 ? "too short" : "too long"));
  }
}

TEST(SurveyQuality, ToldFromTheImagesAloneAgreesWithTheTruth) {
  std::mt19937 rng(8);
  Scene scene;
  scene.take(24, 0.05, rng);
  const MeasuredLength length = scene.length();
  const StageSurvey survey = survey_stage(scene.camera, scene.printed, scene.images, length);
  const SurveyQuality quality = measure_quality(scene.camera, scene.printed, scene.images, length, survey);
  // A corner's noise; what the pose adds is a tenth, what the survey took of the same noise is as much.
  EXPECT_NEAR(quality.left_out_rms_px, 0.05 * std::sqrt(2), 0.007);
  ASSERT_TRUE(quality.halves_m);
  EXPECT_NEAR(*quality.halves_m / *quality.halves_expected_m, 1, 0.3);
  EXPECT_GT(quality.object_px, 0);
  EXPECT_LT(quality.object_px, 0.2);
}

TEST(StageSurvey, SaysWhatIsMissing) {
  std::mt19937 rng(9);
  Scene scene;
  scene.take(3, 0.05, rng);
  expect_error<Error>([&] { survey_stage(scene.camera, scene.printed, scene.images, scene.length()); },
                      {"3 images", "needs 5"});
  scene.take(5, 0.05, rng);
  expect_error<Error>(
      [&] {
        survey_stage(scene.camera, scene.printed, scene.images, {0, 99, 0.2});
      },
      {"tag 99", "not on the stage"});
}

}  // namespace
}  // namespace sheen
