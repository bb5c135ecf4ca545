// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/evaluation/error_ranking.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reconstructor/evaluation/evaluation_report.h"
#include "reconstructor/models/surface_light_field/paper_heuristic.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

TEST(RankCorrelation, IsSpearmans) {
  const std::vector<double> rising{1, 2, 30, 400}, falling{9, 3, 2, -5}, constant{1, 1, 1, 1};
  EXPECT_DOUBLE_EQ(rank_correlation(rising, rising), 1);
  EXPECT_DOUBLE_EQ(rank_correlation(rising, falling), -1);
  EXPECT_TRUE(std::isnan(rank_correlation(rising, constant)));
  EXPECT_TRUE(std::isnan(rank_correlation({}, {})));
  // Without ties 1 - 6 sum d^2 / (n (n^2 - 1)): ranks 0 1 2 3 against 1 0 3 2.
  EXPECT_DOUBLE_EQ(rank_correlation(rising, std::vector<double>{2, 1, 4, 3}), 1 - 6.0 * 4 / (4 * 15));
  // Equal values share their ranks: 0 1.5 1.5 3 against 0 1 2 3.
  EXPECT_DOUBLE_EQ(rank_correlation(rising, std::vector<double>{1, 5, 5, 7}), 4.5 / std::sqrt(5 * 4.5));
}

constexpr double kDistance = 0.5;

/// Diffuse where x is negative; elsewhere a colour that turns with the direction `turns` times over the sphere.
analytic::Scene half_shiny(double turns) {
  return {square_object().surface, analytic::encoded([turns](const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
            const Eigen::Vector3d colour = analytic::waves(p, 0.2);
            if (p.x() < 0) return colour;
            return Eigen::Vector3d(colour.array() + 0.15 * std::sin(turns * M_PI * (d.x() + 0.5 * d.y())));
          })};
}

BaselineHeuristic papers(const std::shared_ptr<const SurfaceLightFieldSnapshot>& model) {
  return {"the paper's", [model](const Eigen::Vector3d& eye) { return PaperHeuristic(*model).seen_from(eye); }};
}

struct Judged {
  ErrorRanking ranking;
  Scores scores;
  std::shared_ptr<const SurfaceLightFieldSnapshot> model;
};

Judged judge(const analytic::Scene& scene, int images) {
  const Object object = square_object();
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures(scene, analytic::eyes(images, kDistance, 0.5)));
  const RayPainter painter(*object.mesh);
  std::vector<HeldOutView> views;
  for (const Capture& unseen : captures(scene, analytic::eyes(7, kDistance, 0.55, 0.9)))
    views.push_back(make_held_out_view(unseen, 1, painter));
  const auto snapshot = model.light_field_snapshot();
  return {judge_error_ranking(views, *snapshot, papers(snapshot), painter), score(views, *snapshot, painter), snapshot};
}

TEST(ErrorRanking, TellsTheHalfThatIsWrongFromTheOneThatIsRight) {
  const Judged judged = judge(half_shiny(4), 30);
  EXPECT_GT(judged.ranking.rank_correlation, 0.6);
  EXPECT_GT(judged.ranking.rank_correlation, judged.ranking.other_rank_correlation);
  const Mesh& mesh = judged.model->mesh();
  const auto quality = judged.model->quality_for({0.06, 0.1, 0.45});
  for (std::size_t t = 0; t < quality.size(); ++t) {
    const float x = (mesh.corner(t, 0).x() + mesh.corner(t, 1).x() + mesh.corner(t, 2).x()) / 3;
    if (x < -0.03f) EXPECT_LT(quality[t].error, 0.01f) << "triangle " << t;
    if (x > 0.03f) EXPECT_GT(quality[t].error, 0.015f) << "triangle " << t;
  }
}

TEST(ErrorRanking, IsRightWithinSomeDecibelsHoweverMuchIsWrong) {
  // A colour that turns smoothly is predicted too carefully: kernels must allow for less.
  for (const auto& [turns, images] :
       {std::pair{1.0, 6}, {2.0, 12}, {4.0, 6}, {4.0, 12}, {4.0, 30}, {8.0, 30}, {8.0, 80}}) {
    const Judged judged = judge(half_shiny(turns), images);
    const double predicted = judged.scores.predicted_inside_db, measured = judged.scores.psnr_inside_db;
    EXPECT_LT(predicted, measured + 3) << turns << " turns, " << images << " images";
    EXPECT_GT(predicted, measured - 7) << turns << " turns, " << images << " images";
  }
}

TEST(ErrorRanking, OfNoViewSaysNothing) {
  const Object object = square_object();
  SurfaceLightField model(object.mesh, plain_options());
  const auto snapshot = model.light_field_snapshot();
  const ErrorRanking judged = judge_error_ranking({}, *snapshot, papers(snapshot), RayPainter(*object.mesh));
  EXPECT_TRUE(std::isnan(judged.rank_correlation));
  ::testing::internal::CaptureStdout();
  print_predictions({}, judged, "the paper's heuristic");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(),
            "predicted PSNR inside the object's edge: - dB, not calibrated (needs 5 held-out views, there are 0); "
            "measured - dB\n");
}

}  // namespace
}  // namespace sheen
