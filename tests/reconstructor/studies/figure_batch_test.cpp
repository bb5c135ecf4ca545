// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/base/format.h"
#include "common/image/color.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/studies/figure.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

TEST(FigureEight, ComparesOnlineAndBatchAtTenRandomViewpoints) {
  const Object ball = sphere_object();
  const std::vector<Capture> all = captures({ball.surface, analytic::two_terms(0.05)}, analytic::eyes(17, 0.5, 0.2));
  const Experiment experiment = load_experiment(ball.mesh, all.size(), [&](std::size_t i) { return all[i]; }, {});
  FigureOptions options{.rank = 2};
  options.model.surface_map = 4;
  options.model.map_detail = 0;
  options.model.patch.factor = {.max_rank = options.rank, .tolerance = 0};
  const BatchRun batch = build_batch(experiment, options, BatchFactorization::quick(options.rank));
  const Figure figure = figure_online_and_batch(experiment, batch, options);
  const auto random = std::find_if(figure.plots.begin(), figure.plots.end(),
                                   [](const auto& plot) { return plot.file == "figure_08_random_viewpoints"; });
  ASSERT_NE(random, figure.plots.end());
  const PlotSeries& measured = random->plot.series.front();
  const std::vector<PosedCamera> views = random_viewpoints(experiment, 10, options.seed);
  ASSERT_EQ(measured.y.size(), views.size());

  const auto online = fill_unseen(*build_online(experiment.mesh, experiment.in_order(), options.model).model);
  const auto in_batch = fill_unseen(*batch.model);
  double mean = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto picture = [&](const Appearance& model) {
      return to_srgb8(experiment.painter->paint(model, views[i].camera, views[i].camera_from_object).beauty);
    };
    const ImageU8 a = picture(*online), b = picture(*in_batch);
    const std::vector<Hit> hits = experiment.painter->cast(views[i].camera, views[i].camera_from_object);
    double squares = 0, values = 0;
    for (std::size_t p = 0; p < hits.size(); ++p) {
      if (!hits[p] || !hits[p].front) continue;
      for (std::size_t c = 0; c < 3; ++c) squares += std::pow((a.data()[3 * p + c] - b.data()[3 * p + c]) / 255.0, 2);
      values += 3;
    }
    EXPECT_NEAR(measured.y[i], -10 * std::log10(squares / values), 1e-6) << i;
    mean += measured.y[i] / 10;
  }
  const std::string words = format("at 10 random viewpoints of the hemisphere round the object %.1f dB", mean);
  EXPECT_NE(figure.ours.find(words), std::string::npos) << figure.ours;
}

}  // namespace
}  // namespace sheen
