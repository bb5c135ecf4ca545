// SPDX-License-Identifier: Apache-2.0
//
// Measures the goals of the ingest pipeline on this machine: `deploy/measure pipeline [--json FILE]`.
// The demo's object (12K triangles) seen by a 1024x768 Bayer camera from 320 places, shaded by texture, one light and a
// glossy lobe; the paper's settings: 16x16 surface maps, 32x32 view maps, rank 6 (000 sec. 4.1).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/order_statistics.h"
#include "common/simulation/camera_path.h"
#include "common/simulation/test_object.h"
#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/effort/effort_control.h"
#include "reconstructor/models/surface_light_field/effort_levels.h"
#include "reconstructor/models/surface_light_field/snapshot.h"
#include "tests/bench/goal_rows.h"
#include "tests/bench/lit_object.h"

namespace sheen {
namespace {

constexpr int kImages = 320;
constexpr int kHoldOutEvery = 20;
constexpr double kBudgetMs = 33;

struct Run {
  std::vector<double> ms;  ///< an accepted image
  double psnr_db = 0;      ///< of the held-out stations
  std::size_t bytes = 0;
  double bytes_per_patch = 0;
  double eye_ms = 0;  ///< what a picture from a new place costs before it is drawn
  std::map<std::string, double> stage_ms;
  Reconstruction::Effort effort;
  CaptureAccount::PatchCounts patches;

  double median_ms() const { return quantile(ms, 0.5); }
  double rate() const { return 1e3 / median_ms(); }
  double around(std::ptrdiff_t image) const {
    const std::ptrdiff_t last = std::min<std::ptrdiff_t>(image + 10, static_cast<std::ptrdiff_t>(ms.size()));
    return quantile(std::vector<double>(ms.begin() + image - 10, ms.begin() + last), 0.5);
  }
};

/// Median over places round the object: the view coefficients of all patches.
double eye_ms(const ModelSnapshot& model) {
  const auto& snapshot = dynamic_cast<const SurfaceLightFieldSnapshot&>(model);
  std::vector<double> ms;
  for (int i = 0; i < 100; ++i) {
    const double azimuth = 2 * M_PI * i / 100;
    const auto start = std::chrono::steady_clock::now();
    snapshot.coefficients_for({0.5 * std::cos(azimuth), 0.5 * std::sin(azimuth), 0.2});
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  return quantile(ms, 0.5);
}

Run ingest(const Mesh& mesh, const SurfaceLightFieldOptions& options, const std::vector<Capture>& captures,
           const Limits& limits, int turns = 1) {
  Reconstruction reconstruction(mesh, options);
  reconstruction.keep_within(limits);
  Run run;
  for (int turn = 0; turn < turns; ++turn)
    for (const Capture& capture : captures) {
      const auto start = std::chrono::steady_clock::now();
      const IngestReport report = reconstruction.ingest(capture);
      const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
      if (report.status == IngestStatus::kAccepted) run.ms.push_back(time.count());
    }
  run.psnr_db = reconstruction.judge().model.psnr_db;
  run.eye_ms = eye_ms(*reconstruction.snapshot());
  run.bytes = reconstruction.model().figures().bytes;
  run.bytes_per_patch = reconstruction.model().figures().bytes_per_patch;
  for (const auto& [stage, seconds] : reconstruction.account().stages()) run.stage_ms[stage] = 1e3 * seconds.median_s();
  run.effort = reconstruction.effort();
  run.patches = reconstruction.account().patches();
  return run;
}

void measure(GoalReport& report) {
  const TestObject object = make_test_object("demo");
  const Camera camera = simulated_camera(1024, 768);
  const LitObject lit(object);
  const std::vector<CameraStation> path = camera_path({.frames = kImages, .jerk_every = 0}, camera);
  std::vector<Capture> captures;
  for (int i = 0; i < kImages; ++i) {
    captures.push_back(lit.photograph(camera, path[i].camera_from_object, static_cast<std::uint64_t>(i + 1)));
    captures.back().purpose = i % kHoldOutEvery == kHoldOutEvery / 2 ? Purpose::kHeldOut : Purpose::kTraining;
  }
  SurfaceLightFieldOptions options;
  options.surface_map = 16;
  options.patch.factor.max_rank = 6;
  options.patch.factor.tolerance = 0;
  const double map_detail = std::exchange(options.map_detail, 0);  // the paper's maps are all alike, and stay

  const Run paper = ingest(object.mesh, options, captures, {});
  nlohmann::json details = paper.stage_ms;
  details["median_ms"] = paper.median_ms();
  details["held_out_db"] = paper.psnr_db;
  report.add(at_least(12, {}, "ingest, paper's settings", paper.rate(), "images/s", details));
  const double p99 = quantile(paper.ms, 0.99) / paper.median_ms();
  report.add(at_most(1.5, {}, "99th percentile over median", p99, "ratio", {{"p99_ms", p99 * paper.median_ms()}}));
  const double early = paper.around(30), late = paper.around(static_cast<std::ptrdiff_t>(paper.ms.size()) - 10);
  report.add(at_most(1.2, {}, "image 300 over image 30", late / early, "ratio",
                     {{"image_30_ms", early}, {"image_300_ms", late}}));
  report.add(at_most(400, {}, "state of a patch", paper.bytes_per_patch / 1e3, "kB"));
  report.add({.name = "view coefficients of all patches for an eye", .value = paper.eye_ms, .unit = "ms"});

  SurfaceLightFieldOptions adapting = options;
  adapting.map_detail = map_detail;
  const Run hurried = ingest(object.mesh, adapting, captures, {.image_ms = kBudgetMs});
  report.add(at_least(30, {}, "ingest, --budget 33ms", hurried.rate(), "images/s",
                      {{"paper_images_per_s", paper.rate()},
                       {"effort_level", hurried.effort.level},
                       {"update_fraction_at_the_end", hurried.effort.update_fraction}}));
  report.add(at_most(0.3, {}, "held-out PSNR lost by it", paper.psnr_db - hurried.psnr_db, "dB",
                     {{"paper_db", paper.psnr_db}, {"budget_db", hurried.psnr_db}}));
  for (int level = 1; level < options.effort_levels(); ++level) {
    const Run at = ingest(object.mesh, at_effort_level(options, level), captures, {});
    report.add({.name = "effort level " + std::to_string(level) + " of the effort levels, cost",
                .value = at.median_ms() / paper.median_ms(),
                .unit = "ratio",
                .compared_with = {{"lost_db", paper.psnr_db - at.psnr_db}}});
  }

  std::vector<Capture> some;
  for (std::size_t i = 0; i < captures.size(); i += 10) some.push_back(captures[i]);
  const Run once = ingest(object.mesh, options, some, {}, 2), often = ingest(object.mesh, options, some, {}, 20);
  report.add(at_most(1.01, {}, "memory, session ten times as long", double(often.bytes) / double(once.bytes), "ratio",
                     {{"images_per_s", often.rate()},
                      {"lost_db", once.psnr_db - often.psnr_db},
                      {"patches_skipped", often.patches.skipped},
                      {"patches_updated", often.patches.updated}}));
}

}  // namespace
}  // namespace sheen

int main(int argc, char** argv) {
  return sheen::measure_goals(argc, argv, "Measures the goals of the ingest pipeline on this machine.", sheen::measure);
}
