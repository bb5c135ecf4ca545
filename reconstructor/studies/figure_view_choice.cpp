// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <random>

#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/models/surface_light_field/image_worth.h"
#include "reconstructor/studies/figure.h"
#include "reconstructor/evaluation/paper_heuristic.h"

namespace sheen {
namespace {

/// A photograph that may be chosen: where it was taken from and what it shows.
struct Candidate {
  const Capture* capture;
  Eigen::Vector3d eye, direction;  ///< direction: unit, from the object's centre
  struct Seen {
    std::uint32_t triangle;
    float pixels;
  };
  std::vector<Seen> seen;
};

std::vector<Candidate> candidates_of(const Experiment& experiment) {
  const BoundingSphere bounds = bounding_sphere(*experiment.mesh);
  std::vector<Candidate> candidates;
  for (const Capture& capture : experiment.training) {
    Candidate c{.capture = &capture, .eye = camera_centre(capture.pose.camera_from_object)};
    c.direction = (c.eye - bounds.centre).normalized();
    std::vector<float> pixels(experiment.mesh->triangles.size(), 0);
    for (const Hit& hit : experiment.painter->cast(capture.camera, capture.pose.camera_from_object))
      if (hit && hit.front) ++pixels[hit.triangle];
    for (std::uint32_t t = 0; t < pixels.size(); ++t)
      if (pixels[t] > 0) c.seen.push_back({t, pixels[t]});
    candidates.push_back(std::move(c));
  }
  return candidates;
}

/// The next image to take, given the model of those taken. `left` is not empty.
using Choice = std::function<std::size_t(const std::vector<Candidate>&, const std::vector<std::size_t>& taken,
                                         const std::vector<std::size_t>& left, SurfaceLightField& model)>;

std::size_t most(const std::vector<std::size_t>& left, const std::function<double(std::size_t)>& worth) {
  std::size_t best = left.front();
  double highest = -std::numeric_limits<double>::infinity();
  for (const std::size_t i : left)
    if (const double w = worth(i); w > highest) {
      highest = w;
      best = i;
    }
  return best;
}

std::size_t by_paper_heuristic(const std::vector<Candidate>& all, const std::vector<std::size_t>&,
                               const std::vector<std::size_t>& left, SurfaceLightField& model) {
  const auto snapshot = model.light_field_snapshot();
  const PaperHeuristic heuristic(*snapshot);
  return most(left, [&](std::size_t i) {
    const std::vector<float> of_triangle = heuristic.seen_from(all[i].eye);
    double sum = 0, pixels = 0;
    for (const auto& [triangle, count] : all[i].seen) {
      sum += count * of_triangle[triangle];
      pixels += count;
    }
    return pixels > 0 ? sum / pixels : 0;
  });
}

std::size_t by_worth(const std::vector<Candidate>& all, const std::vector<std::size_t>&,
                     const std::vector<std::size_t>& left, SurfaceLightField& model) {
  std::vector<Eigen::Vector3d> eyes;
  for (const Candidate& c : all) eyes.push_back(c.eye);
  const std::vector<double> worth = image_worth(*model.light_field_snapshot(), eyes);
  return most(left, [&](std::size_t i) { return worth[i]; });
}

std::size_t farthest(const std::vector<Candidate>& all, const std::vector<std::size_t>& taken,
                     const std::vector<std::size_t>& left, SurfaceLightField&) {
  return most(left, [&](std::size_t i) {
    double nearest = -1;
    for (const std::size_t t : taken) nearest = std::max(nearest, all[i].direction.dot(all[t].direction));
    return -nearest;
  });
}

/// Held-out PSNR after each of `counts` images.
std::vector<double> convergence(const Experiment& experiment, const std::vector<Candidate>& candidates,
                                const SurfaceLightFieldOptions& options, const std::vector<std::size_t>& counts,
                                std::size_t first, const Choice& choose) {
  SurfaceLightField model(experiment.mesh, options);
  std::vector<std::size_t> taken, left(candidates.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  std::vector<double> psnr;
  while (psnr.size() < counts.size() && !left.empty()) {
    const std::size_t next = taken.empty() ? first : choose(candidates, taken, left, model);
    model.ingest(*candidates[next].capture);
    taken.push_back(next);
    std::erase(left, next);
    if (taken.size() == counts[psnr.size()])
      psnr.push_back(
          mean_psnr_db(experiment.held_out, *fill_unseen(*model.light_field_snapshot()), *experiment.painter));
  }
  return psnr;
}

}  // namespace

Figure figure_view_choice(const Experiment& experiment, const FigureOptions& options) {
  const std::vector<Candidate> candidates = candidates_of(experiment);
  std::vector<std::size_t> counts;
  for (const std::size_t n : {2, 4, 6, 8, 12, 16, 20, 26, 32, 40, 50})
    if (n < candidates.size() && (n <= 32 || !options.quick)) counts.push_back(n);
  const std::vector<double> x(counts.begin(), counts.end());
  constexpr int kStarts = 4;  // with fewer of them the first image decides
  const auto mean_over_starts = [&](const std::function<Choice(int)>& choice_of) {
    std::vector<double> mean(counts.size(), 0);
    for (int s = 0; s < kStarts; ++s) {
      const std::size_t first = candidates.size() * static_cast<std::size_t>(s) / static_cast<std::size_t>(kStarts);
      const std::vector<double> psnr = convergence(experiment, candidates, options.model, counts, first, choice_of(s));
      for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += psnr[i] / kStarts;
    }
    return mean;
  };
  const auto mean_of = [](const std::vector<double>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
  };
  const std::vector<double> heuristic = mean_over_starts([](int) { return by_paper_heuristic; });
  const std::vector<double> worth = mean_over_starts([](int) { return by_worth; });
  const std::vector<double> spread = mean_over_starts([](int) { return farthest; });
  const std::vector<double> random = mean_over_starts([&](int s) -> Choice {
    return [generator = std::mt19937_64(options.seed + static_cast<std::uint64_t>(s))](
               const auto&, const auto&, const std::vector<std::size_t>& left, auto&) mutable {
      return left[generator() % left.size()];
    };
  });
  Figure figure{.number = 10, .title = "Images chosen by the quality heuristic"};
  figure.paper = "Chosen by the heuristic, images bring the model up much faster than chosen at random.";
  figure.ours = format(
      "Held-out PSNR, mean over 2 to %zu images and %d first images: by worth (what the window advises) %.2f dB, by "
      "the "
      "paper's heuristic %.2f dB, farthest view %.2f dB, random %.2f dB.",
      counts.back(), kStarts, mean_of(worth), mean_of(heuristic), mean_of(spread), mean_of(random));
  figure.holds = mean_of(worth) > mean_of(random) && mean_of(worth) > mean_of(spread);
  Plot plot{.title = "Convergence (figure 10)", .x = {.label = "images"}, .y = {.label = "held-out PSNR (dB)"}};
  plot.series.push_back({.name = "the paper's heuristic", .x = x, .y = heuristic});
  plot.series.push_back({.name = "worth of the image", .x = x, .y = worth});
  plot.series.push_back({.name = "farthest view", .x = x, .y = spread});
  plot.series.push_back({.name = "random", .x = x, .y = random});
  figure.plots.push_back({"figure_10_view_choice", std::move(plot)});
  return figure;
}

}  // namespace sheen
