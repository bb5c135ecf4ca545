// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/running_statistics.h"
#include "common/capture/capture.h"
#include "common/geometry/mesh.h"
#include "reconstructor/effort/effort_plan.h"
#include "reconstructor/evaluation/held_out.h"
#include "reconstructor/models/appearance_model.h"
#include "reconstructor/models/model_settings.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

/// What became of the captures so far.
struct FrameCounts {
  std::uint64_t received = 0, accepted = 0, held_out = 0;
  std::map<std::string, std::uint64_t> refused;  ///< by reason
  std::uint64_t withdrawn = 0;                   ///< taken back by a person
};

/// A capture that the reconstruction was given, and what became of it.
struct KnownCapture {
  std::string source_session;  ///< with `sequence`, of the capture
  std::uint64_t sequence = 0;
  IngestStatus status = IngestStatus::kRefused;
  std::string reason;     ///< of a refusal
  bool repeated = false;  ///< the model took nothing of it: it shows what an earlier one does
  std::size_t patches_skipped = 0;
  float exposure_gain = 1;  ///< that its values, or those of a held-out view, were divided by
};

/// One object being reconstructed: the model, the views that judge it, and the account of every capture. Live capture
/// and files go through the same `ingest`, so that the same captures in the same order give the same bits.
class Reconstruction {
 public:
  Reconstruction(Mesh mesh, const ModelSettings& settings);

  /// Before the first capture: keeps the time per image and the memory within the limits, as far as the effort levels
  /// go (effort_control.h). `record`, of `captures` earlier ones: what an earlier run decided. `measured`: what the
  /// effort levels cost and lose on this scene: the cheapest that reaches a PSNR asked for is taken; without it a level
  /// that is taken for its time is judged on the first images. Throws ConfigError.
  void keep_within(const Limits& limits, const std::string& record = {}, std::uint64_t captures = 0,
                   MeasuredLevels measured = {});
  /// Before the first capture: the model is no finer than at this effort level.
  void begin_at(int level);
  const Limits& limits() const { return effort_.limits(); }

  IngestReport ingest(const Capture& capture);
  enum class Withdrawn {
    kExactly,  ///< the model is, to the bit, one that never saw it: it was refused, held out or a repetition
    kNearly,   ///< AppearanceModel::withdraw
    kNot,      ///< the model can only be rebuilt: it is the first image
  };
  /// Takes a capture back, at once.
  Withdrawn withdraw(const Capture& capture);
  /// Counts captures that were withdrawn and so are not ingested.
  void leave_out(std::uint64_t captures);
  /// Counts captures whose files cannot be read among the refused.
  void refuse_damaged(std::uint64_t captures);
  /// Forgets every capture: what is ingested from now on gives the bits that it gives a new one which follows the
  /// present `effort_record`.
  void restart();

  const Mesh& mesh() const { return *mesh_; }
  std::shared_ptr<const ModelSnapshot> snapshot() { return model_->snapshot(); }
  /// No capture follows: AppearanceModel::finish.
  void finish();
  const AppearanceModel& model() const { return *model_; }
  const RayPainter& painter() const { return painter_; }
  const std::vector<HeldOutView>& held_out() const { return held_out_; }
  const FrameCounts& counts() const { return counts_; }
  /// All captures that count.
  const std::vector<KnownCapture>& captures() const { return captures_; }
  const std::map<std::string, RunningStatistics>& stages() const { return stages_; }
  const RunningStatistics& updates() const { return updates_; }  ///< all stages of an image together

  /// What became of the patches that the accepted images showed.
  struct PatchCounts {
    std::uint64_t updated = 0, skipped = 0, left_out = 0;
  };
  const PatchCounts& patches() const { return patches_; }
  /// How hard the model works: its effort level, and how much of what an image shows it updates.
  struct Effort {
    int level = 0;
    double update_fraction = 1;
    bool operator==(const Effort&) const = default;
  };
  Effort effort() const;
  MemoryAccount memory() const;
  /// By which this process has grown since there is a reconstruction, in bytes: now, or when it was finished.
  double resident_growth() const;
  /// What was decided to keep the budget, for a later run to follow; empty when nothing was.
  std::string effort_record() const { return effort_.record(); }

  double images_per_s() const;  ///< accepted images over the time spent on ingesting them

  /// The held-out views, seen by the model and by its constant-colour twin.
  struct Judgement {
    Scores model, constant;
  };
  Judgement judge(const StepsDone& progress = {});

 private:
  /// An image that the effort level of a budget is chosen by.
  struct ProbeImage {
    Capture capture;
    double held_out_bytes = 0;   ///< of the views held out before it
    float known_gain = 1;        ///< by which the camera says that it is brighter than the model's level
    double predicted_error = 0;  ///< mean square, encoded, of predicting it from those before; NaN where none did
  };
  IngestReport take(const Capture& capture);
  void note(const Capture& capture, const IngestReport& report);
  void note_accepted(const Capture& capture, const IngestReport& report);
  bool fit_memory(const Capture& first);
  void stay_within_memory();
  void choose_level();
  void fold_probe_at(int level);
  double error_on(const std::vector<HeldOutView>& views);
  double predicted_error() const;
  void forget_work();

  double resident_before_, resident_at_finish_ = 0;
  std::shared_ptr<const Mesh> mesh_;
  std::unique_ptr<ModelSettings> asked_;
  std::unique_ptr<AppearanceModel> model_;
  RayPainter painter_;
  std::vector<HeldOutView> held_out_;
  FrameCounts counts_;
  std::vector<KnownCapture> captures_;
  std::map<std::string, RunningStatistics> stages_;
  RunningStatistics updates_;
  PatchCounts patches_;

  EffortPlan effort_;
  std::optional<CaptureSize> image_size_;  ///< of the first image
  double held_out_bytes_ = 0;
  bool memory_exceeded_ = false;   ///< although all have: told once
  std::vector<ProbeImage> probe_;  ///< the accepted images until the effort level is chosen
};

}  // namespace sheen
