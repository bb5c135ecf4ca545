// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <random>

#include "common/base/format.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/models/surface_light_field/image_worth.h"
#include "reconstructor/models/surface_light_field/paper_heuristic.h"
#include "reconstructor/models/surface_light_field/quality.h"
#include "reconstructor/studies/figure.h"

namespace sheen {
namespace {

constexpr std::size_t kVerticesLookedAt = 400;

std::size_t vertex_stride(const Mesh& mesh) {
  return std::max<std::size_t>(1, mesh.vertices.size() / kVerticesLookedAt);
}

/// A photograph that may be chosen: where it was taken from and what it shows of the vertices looked at.
struct Candidate {
  const Capture* capture;
  Eigen::Vector3d eye, direction;  ///< direction: unit, from the object's centre
  struct Seen {
    std::size_t vertex;
    float pixels;  ///< of the triangles round it
  };
  std::vector<Seen> seen;
};

std::vector<Candidate> candidates_of(const Experiment& experiment) {
  const Mesh& mesh = *experiment.mesh;
  const BoundingSphere bounds = bounding_sphere(mesh);
  std::vector<Candidate> candidates;
  for (const Capture& capture : experiment.training) {
    Candidate c{.capture = &capture, .eye = camera_centre(capture.pose.camera_from_object)};
    c.direction = (c.eye - bounds.centre).normalized();
    std::vector<float> pixels(mesh.vertices.size(), 0);
    for (const Hit& hit : experiment.painter->cast(capture.camera, capture.pose.camera_from_object))
      if (hit && hit.front)
        for (const std::uint32_t v : mesh.triangles[hit.triangle]) ++pixels[v];
    for (std::size_t v = 0; v < pixels.size(); v += vertex_stride(mesh))
      if (pixels[v] > 0) c.seen.push_back({v, pixels[v]});
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

/// The image whose object pixels have the highest mean of a quality heuristic: both heuristics are added up like this.
std::size_t most_wanting(const std::vector<Candidate>& all, const std::vector<std::size_t>& left,
                         const std::function<float(std::size_t vertex, const Eigen::Vector3d& eye)>& heuristic) {
  return most(left, [&](std::size_t i) {
    double sum = 0, pixels = 0;
    for (const auto& [vertex, count] : all[i].seen) {
      sum += count * heuristic(vertex, all[i].eye);
      pixels += count;
    }
    return pixels > 0 ? sum / pixels : 0;
  });
}

std::size_t by_paper_heuristic(const std::vector<Candidate>& all, const std::vector<std::size_t>&,
                               const std::vector<std::size_t>& left, SurfaceLightField& model) {
  const auto snapshot = model.light_field_snapshot();
  const PaperHeuristic heuristic(*snapshot, vertex_stride(snapshot->mesh()));
  return most_wanting(all, left,
                      [&](std::size_t vertex, const Eigen::Vector3d& eye) { return heuristic.of_vertex(vertex, eye); });
}

/// What the window paints red.
std::size_t by_red(const std::vector<Candidate>& all, const std::vector<std::size_t>&,
                   const std::vector<std::size_t>& left, SurfaceLightField& model) {
  const auto snapshot = model.light_field_snapshot();
  return most_wanting(all, left, [&](std::size_t vertex, const Eigen::Vector3d& eye) {
    const SeenVertex* from = snapshot->seen_vertex(vertex);
    const Eigen::Vector3f direction = (eye.cast<float>() - snapshot->mesh().vertices[vertex]).normalized();
    return from ? assess_vertex(*from, direction, snapshot->common_sill()).heuristic() : 1;
  });
}

/// Where the window sends the person (`advise_next_view`), with the photographs that are left for places.
std::size_t by_guidance(const std::vector<Candidate>& all, const std::vector<std::size_t>&,
                        const std::vector<std::size_t>& left, SurfaceLightField& model) {
  std::vector<Eigen::Vector3d> eyes;
  for (const std::size_t i : left) eyes.push_back(all[i].eye);
  const std::vector<double> worth = image_worth(*model.light_field_snapshot(), eyes);
  return left[static_cast<std::size_t>(std::max_element(worth.begin(), worth.end()) - worth.begin())];
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

/// A rule's curve: mean over first images, and twice its standard error.
PlotSeries curve_of(std::string name, const std::vector<std::size_t>& counts,
                    const std::vector<std::vector<double>>& starts) {
  PlotSeries series{.name = std::move(name)};
  const auto n = static_cast<double>(starts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    double mean = 0, squares = 0;
    for (const std::vector<double>& start : starts) mean += start[i] / n;
    for (const std::vector<double>& start : starts) squares += (start[i] - mean) * (start[i] - mean);
    series.add(static_cast<double>(counts[i]), mean);
    series.bars.push_back(2 * std::sqrt(squares / (n - 1) / n));
  }
  return series;
}

/// Some of 1 .. all, closer together where there are few; `all` is the last.
std::vector<std::size_t> counts_up_to(std::size_t all) {
  std::vector<std::size_t> counts;
  for (double n = 2; n < static_cast<double>(all); n = std::max(n + 1, 1.25 * n))
    counts.push_back(static_cast<std::size_t>(n));
  counts.push_back(all);
  return counts;
}

std::string images_text(double images) {
  return std::isnan(images) ? "never" : format("%.1f", images);
}

}  // namespace

double images_to_reach(const PlotSeries& curve, double y) {
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (curve.y[i] < y) continue;
    if (i == 0) return curve.x[0];
    const double fraction = (y - curve.y[i - 1]) / (curve.y[i] - curve.y[i - 1]);
    return curve.x[i - 1] + fraction * (curve.x[i] - curve.x[i - 1]);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

Figure figure_view_choice(const Experiment& experiment, const FigureOptions& options) {
  const std::vector<Candidate> candidates = candidates_of(experiment);
  const std::vector<std::size_t> counts = counts_up_to(candidates.size());
  const std::size_t starts = std::min<std::size_t>(options.quick ? 4 : 12, candidates.size());
  const auto curve = [&](const char* name, const std::function<Choice(std::size_t)>& choice_of) {
    std::vector<std::vector<double>> psnr;
    for (std::size_t s = 0; s < starts; ++s)
      psnr.push_back(
          convergence(experiment, candidates, options.model, counts, candidates.size() * s / starts, choice_of(s)));
    return curve_of(name, counts, psnr);
  };
  const auto always = [](const Choice& choice) { return [choice](std::size_t) { return choice; }; };
  Plot plot{.title = "Convergence (figure 10)", .x = {.label = "images"}, .y = {.label = "held-out PSNR (dB)"}};
  plot.series.push_back(curve("guidance", always(by_guidance)));
  plot.series.push_back(curve("mean of the red", always(by_red)));
  plot.series.push_back(curve("mean of the paper's heuristic", always(by_paper_heuristic)));
  plot.series.push_back(curve("farthest view", always(farthest)));
  plot.series.push_back(curve("random", [&](std::size_t s) -> Choice {
    return
        [generator = std::mt19937_64(options.seed + s)](const auto&, const auto&, const std::vector<std::size_t>& left,
                                                        auto&) mutable { return left[generator() % left.size()]; };
  }));

  const PlotSeries &guidance = plot.series.front(), &far = plot.series[3];
  const double final_db = far.y.back();
  const auto all = static_cast<double>(candidates.size());
  Figure figure{.number = 10, .title = "Images chosen by the quality heuristic"};
  figure.paper = "Chosen by the heuristic, images bring the model up much faster than chosen at random.";
  figure.ours = format(
      "%zu first images, bars are twice the standard error. Farthest view ends at %.2f dB with all %zu "
      "images. Images to that, and to 0.1 dB less:",
      starts, final_db, candidates.size());
  for (const PlotSeries& series : plot.series)
    figure.ours += " " + series.name + " " + images_text(images_to_reach(series, final_db)) + ", " +
                   images_text(images_to_reach(series, final_db - 0.1)) + ";";
  figure.ours += format(" the goal is %.1f by guidance.", 0.75 * all);
  figure.holds = images_to_reach(guidance, final_db) <= 0.75 * all;
  figure.plots.push_back({"figure_10_view_choice", std::move(plot)});
  return figure;
}

}  // namespace sheen
