// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/experiment.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <numeric>
#include <random>
#include <utility>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "reconstructor/radiance/capture_rules.h"
#include "reconstructor/radiance/radiance_image.h"

namespace sheen {
namespace {

bool shows_object(const Capture& capture, const RayPainter& painter) {
  if (!capture.pose.usable()) return false;
  const std::vector<Hit> hits = painter.cast(capture.camera, capture.pose.camera_from_object);
  for (std::size_t i = 0; i < hits.size(); ++i)
    if (hits[i] && hits[i].front && (capture.mask.empty() || capture.mask.data()[i] != 0)) return true;
  return false;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

double process_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::vector<const Capture*> Experiment::in_order() const {
  std::vector<const Capture*> captures;
  for (const Capture& capture : training) captures.push_back(&capture);
  return captures;
}

Experiment load_experiment(std::shared_ptr<const Mesh> mesh, std::size_t count,
                           const std::function<Capture(std::size_t)>& read, const ExperimentOptions& options,
                           const std::function<void(std::size_t)>& done) {
  Experiment experiment;
  experiment.mesh = std::move(mesh);
  experiment.painter = std::make_shared<RayPainter>(*experiment.mesh);
  std::size_t used = 0;
  double reference = 0;
  std::vector<HeldOutView> held_out;
  for (std::size_t i = 0; i < count; ++i) {
    Capture capture = read(i);
    if (shows_object(capture, *experiment.painter)) {
      ++used;
      const double product = exposure_product(capture);
      if (used == 1) reference = product;
      if (reference > 0 && product > 0 && product != reference)
        capture = levelled(std::move(capture), static_cast<float>(product / reference));
      if (is_held_out(capture, options.hold_out_every)) {
        held_out.push_back(make_held_out_view(capture, 1, *experiment.painter));
      } else {
        capture.purpose = Purpose::kTraining;
        experiment.training.push_back(std::move(capture));
      }
    }
    if (done) done(i + 1);
  }
  if (experiment.training.empty())
    throw Error("none of the " + std::to_string(count) +
                " images shows the mesh; check that both are in the same frame and units");
  if (held_out.empty())
    throw Error("there is no held-out view to judge by: no test view is named and none was held out");
  const std::size_t kept = std::min(held_out.size(), std::max<std::size_t>(options.max_held_out, 1));
  for (std::size_t i = 0; i < kept; ++i) experiment.held_out.push_back(std::move(held_out[i * held_out.size() / kept]));
  return experiment;
}

std::vector<PosedCamera> random_viewpoints(const Experiment& experiment, std::size_t count, std::uint64_t seed) {
  const Eigen::Vector3d centre = bounding_sphere(*experiment.mesh).centre;
  double distance = 0;
  Eigen::Vector3d pole = Eigen::Vector3d::Zero();
  for (const Capture& capture : experiment.training) {
    const Eigen::Vector3d from_centre = camera_centre(capture.pose.camera_from_object) - centre;
    distance += from_centre.norm() / static_cast<double>(experiment.training.size());
    pole += from_centre.normalized();
  }
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<PosedCamera> views;
  for (std::size_t i = 0; i < count; ++i) {
    Eigen::Vector3d direction(normal(engine), normal(engine), normal(engine));
    direction.normalize();
    if (direction.dot(pole) < 0) direction = -direction;
    const Capture& like = experiment.training[i * experiment.training.size() / count];
    views.push_back({like.camera, look_at(centre + distance * direction, centre, pole)});
  }
  return views;
}

double OnlineRun::median_ms() const {
  return image_ms.empty() ? 0 : median(std::vector(image_ms));
}

double OnlineRun::total_s() const {
  return shown_s + finish_s + 1e-3 * std::accumulate(image_ms.begin(), image_ms.end(), 0.0);
}

OnlineRun build_online(std::shared_ptr<const Mesh> mesh, std::span<const Capture* const> captures,
                       const SurfaceLightFieldOptions& options) {
  OnlineRun run;
  SurfaceLightField model(std::move(mesh), options);
  const double cpu = process_cpu_s();
  for (const Capture* capture : captures) {
    if (capture == captures.back()) {
      const auto before = std::chrono::steady_clock::now();
      model.light_field_snapshot();
      run.shown_s = seconds_since(before);
    }
    const auto start = std::chrono::steady_clock::now();
    const IngestReport report = model.ingest(*capture);
    run.image_ms.push_back(1e3 * seconds_since(start));
    if (const auto stage = report.stage_ms.find("factorize"); stage != report.stage_ms.end())
      run.factorize_ms += stage->second / static_cast<double>(captures.size());
  }
  const auto start = std::chrono::steady_clock::now();
  run.model = model.light_field_snapshot();
  run.finish_s = seconds_since(start);
  run.cpu_s = process_cpu_s() - cpu;
  run.bytes = model.bytes();
  const std::vector<std::size_t> histogram = model.figures().rank_histogram;
  double patches = 0, ranks = 0;
  for (std::size_t r = 0; r < histogram.size(); ++r) {
    patches += static_cast<double>(histogram[r]);
    ranks += static_cast<double>(r * histogram[r]);
  }
  run.mean_rank = patches > 0 ? ranks / patches : 0;
  return run;
}

}  // namespace sheen
