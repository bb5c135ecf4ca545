// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <stop_token>
#include <thread>

#include "common/base/progress.h"
#include "reconstructor/capture/capture_loop.h"
#include "reconstructor/refinement/refinement_images.h"

namespace sheen {

/// Looks at the images of a capture so far, those that may train a model: the mesh that the model is to go over to;
/// null where the one that it has is the best. `told`: what the report says of it.
using LookAtMesh = std::function<std::shared_ptr<const Mesh>(const RefinementImages& images, const StepsDone& progress,
                                                             nlohmann::json& told)>;

struct LiveMeshOptions {
  const char* name = "refinement";  ///< of the looks, in the report
  int hold_out_every = 0;           ///< as the model's settings have it
  std::size_t fewest_images = 8;    ///< of fewer, those that judge say little
  std::uint64_t first = 24;         ///< captures, before the first look
  double growth = 2;                ///< times as many each time: all looks together cost twice the last one
  double growth_at_end = 1.25;      ///< since the last look, for another one when the capture is over; 1: always one
};

/// A mesh that becomes better while a capture runs: the images in its journal are looked at again and again as they
/// become more, on a thread that lets every other one go first, and the model goes over to what a look finds. The
/// loop's status says how far a look has come.
class LiveMesh {
 public:
  /// The loop awaits its last mesh.
  LiveMesh(CaptureLoop& loop, std::filesystem::path session_folder, LiveMeshOptions options, LookAtMesh look);
  ~LiveMesh();

  void start();
  const char* name() const { return options_.name; }
  /// Each look: {"images", "seconds"} and what it told.
  nlohmann::json report() const;

 private:
  void run(const std::stop_token& stop);
  void look_until_over(const std::stop_token& stop);
  bool many_more(std::uint64_t captures, std::uint64_t looked_at) const;
  LoopStatus wait_for(std::uint64_t captures, const std::stop_token& stop) const;
  std::shared_ptr<const Mesh> look(const LoopStatus& begun, const std::stop_token& stop);
  StepsDone steps_of(const LoopStatus& begun, const std::stop_token& stop);

  CaptureLoop& loop_;
  std::filesystem::path folder_;
  LiveMeshOptions options_;
  LookAtMesh look_;
  mutable std::mutex mutex_;
  std::unique_ptr<nlohmann::json> looks_;
  std::jthread thread_;
};

/// Whole or not at all: a start after kill -9 reads it.
void save_mesh_of_session(const std::filesystem::path& session_folder, const char* name,
                          const std::function<void(const std::filesystem::path& file)>& save);

}  // namespace sheen
