// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <future>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <stop_token>
#include <utility>

#include "common/base/progress.h"
#include "reconstructor/capture/capture_loop.h"
#include "reconstructor/capture/live_mesh.h"

namespace sheen {

enum class EndStage : std::uint8_t {
  kCapturing,  ///< the end has not begun
  kFinishing,  ///< waiting captures are added to the model
  kRefining,   ///< the mesh is refined a last time
  kSaving,
  kJudging,  ///< the model is compared with the held-out views
};

struct EndProgress {
  EndStage stage = EndStage::kCapturing;
  /// Images; steps of the refinement; parts of the model's files or tries to make it small; pictures.
  std::uint64_t done = 0, total = 0;
};

/// What becomes of a capture after its last image, on a thread of its own so that whoever watches is told meanwhile: no
/// more is received, waiting captures are added, the mesh is refined where that was asked for, the model is saved into
/// `session_folder`/model, its held-out views are judged. As bounded as the journal is; `stop` ends it earlier.
class CaptureEnd {
 public:
  /// `size`: that of the saved model, as `save_reconstruction` takes it. `live_mesh`: whose last mesh
  /// the loop awaits; or null.
  CaptureEnd(CaptureLoop& loop, Reconstruction& reconstruction, std::filesystem::path session_folder,
             std::optional<CompressionTarget> size, const LiveMesh* live_mesh)
      : loop_(loop),
        reconstruction_(reconstruction),
        folder_(std::move(session_folder)),
        size_(std::move(size)),
        live_mesh_(live_mesh) {}
  ~CaptureEnd() { stop_.request_stop(); }  // the future waits

  void begin();
  bool over() const;
  EndProgress progress() const;
  /// Asks it to end without what is still to be done. False when it has not after `patience`: one image, or the writing
  /// of one part of the model, takes longer.
  bool stop(std::chrono::milliseconds patience);

  struct Result {
    std::shared_ptr<const nlohmann::json> report;
    std::optional<std::filesystem::path> model;  ///< none where no image was accepted
  };
  /// Once it is over: what came of it; nothing when it was stopped. Throws what went wrong.
  std::optional<Result> result() { return ending_.get(); }

 private:
  std::optional<Result> run();
  void fold_in_the_journal();
  void show(EndStage stage, std::uint64_t done, std::uint64_t total);
  StepsDone steps_of(EndStage stage);

  CaptureLoop& loop_;
  Reconstruction& reconstruction_;
  std::filesystem::path folder_;
  std::optional<CompressionTarget> size_;
  const LiveMesh* live_mesh_;
  std::stop_source stop_;
  mutable std::mutex mutex_;
  EndProgress progress_;
  std::future<std::optional<Result>> ending_;
};

}  // namespace sheen
