// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "common/base/progress.h"
#include "reconstructor/capture/capture_loop.h"
#include "reconstructor/refinement/mesh_judgement.h"

namespace sheen {

/// In a session's folder: the mesh that its model went over to.
inline constexpr const char* kRefinedMeshFile = "refined.ply";

struct LiveRefinementOptions {
  int hold_out_every = 0;       ///< as the model's settings have it
  std::uint64_t first = 24;     ///< captures, before the mesh is looked at first
  double growth = 2;            ///< times as many each time: all looks together cost twice the last one
  double growth_at_end = 1.25;  ///< since the last look, for another one when the capture is over
  std::function<void(const std::string&)> on_finding;  ///< at the end: what is wrong with the given mesh as a whole
};

/// Refines the mesh of a running capture against the images in its journal, on a thread of its own that lets every
/// other one go first, again and again as they become more. Each time it begins at the mesh that was given, and the
/// model goes over to the new mesh only where images that were left out are predicted better than by the one it has
/// (`refine_and_judge`). The mesh that it went over to stands in the session's folder. The loop's status says how far a
/// look has come.
class LiveRefinement {
 public:
  /// The loop awaits its last mesh. `given`: as the user gave it; `present`: the one that the model has.
  LiveRefinement(CaptureLoop& loop, std::filesystem::path session_folder, std::shared_ptr<const Mesh> given,
                 std::shared_ptr<const Mesh> present, LiveRefinementOptions options);
  ~LiveRefinement();

  void start();
  /// Each look: {"images", "gain_db", "standard_error_db", "seconds", "mesh": "refined", "as before" or "given"}.
  nlohmann::json report() const;

 private:
  void run(const std::stop_token& stop);
  void look_until_over(const std::stop_token& stop);
  bool many_more(std::uint64_t captures, std::uint64_t looked_at) const;
  LoopStatus wait_for(std::uint64_t captures, const std::stop_token& stop) const;
  std::shared_ptr<const Mesh> look(std::uint64_t captures, const std::stop_token& stop);
  StepsDone steps_of(std::uint64_t captures, const std::stop_token& stop);

  CaptureLoop& loop_;
  std::filesystem::path folder_;
  std::shared_ptr<const Mesh> given_, present_;
  LiveRefinementOptions options_;
  mutable std::mutex mutex_;
  std::unique_ptr<nlohmann::json> looks_;
  std::jthread thread_;
};

/// The mesh that a session's model went over to; null where it did to none. Throws FileError, also where it is not one
/// that the `given` mesh was refined to.
std::shared_ptr<const Mesh> refined_mesh_of(const std::filesystem::path& session_folder, const Mesh& given);

}  // namespace sheen
