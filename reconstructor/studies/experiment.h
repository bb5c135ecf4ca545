// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/capture/capture.h"
#include "common/geometry/mesh.h"
#include "reconstructor/evaluation/held_out.h"
#include "reconstructor/models/surface_light_field/surface_light_field.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

/// The photographs of an experiment: read and decoded once, used by every run. Which views judge is decided once too,
/// so that neither the order nor the settings of a run change it.
struct Experiment {
  std::shared_ptr<const Mesh> mesh;
  std::shared_ptr<const RayPainter> painter;
  std::vector<Capture> training;  ///< in the order they were taken; their grey levels mean the same in all
  std::vector<HeldOutView> held_out;

  /// The training captures in their order.
  std::vector<const Capture*> in_order() const;
};

struct ExperimentOptions {
  int hold_out_every = 8;         ///< where the captures do not say themselves
  std::size_t max_held_out = 12;  ///< views that judge, spread over all held-out ones: what a run's scoring costs
};

/// Reads captures 0 .. count - 1. Captures without a pose or that show nothing of the mesh are left out. Where cameras
/// report exposures that differ, images are brought to the first one's level. `done` is called after each. Throws Error
/// when nothing is left to learn from.
Experiment load_experiment(std::shared_ptr<const Mesh> mesh, std::size_t count,
                           const std::function<Capture(std::size_t)>& read, const ExperimentOptions& options,
                           const std::function<void(std::size_t)>& done = {});

/// So many cameras at random places on the hemisphere round the object whose pole is the mean direction of the training
/// images, as far from it as they are on average; they look at its centre, each as one of the training cameras.
std::vector<PosedCamera> random_viewpoints(const Experiment& experiment, std::size_t count, std::uint64_t seed);

/// A light field built online, and what it took.
struct OnlineRun {
  std::shared_ptr<const SurfaceLightFieldSnapshot> model;  ///< without a guess for patches that no image reached
  std::vector<double> image_ms;                            ///< wall time of ingesting each image, snapshots apart
  double factorize_ms = 0;  ///< mean wall time per image of folding columns into the patches and choosing kernels
  double cpu_s = 0;         ///< processor time of all images and of the model at the end, all threads
  double shown_s = 0;       ///< wall time of the model before the last image: a capture is watched while it grows
  double finish_s = 0;      ///< wall time from the last image to the model
  std::size_t bytes = 0;    ///< of the patches' state
  double mean_rank = 0;     ///< over patches that an image reached
  double median_ms() const;
  double total_s() const;  ///< wall time of all images and of the model at the end
};

/// Ingests the captures, one after the other. What the options say of held-out images has no meaning here.
OnlineRun build_online(std::shared_ptr<const Mesh> mesh, std::span<const Capture* const> captures,
                       const SurfaceLightFieldOptions& options);

/// Processor time of this process, all threads, seconds.
double process_cpu_s();

}  // namespace sheen
