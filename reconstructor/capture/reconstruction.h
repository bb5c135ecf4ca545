// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/capture/capture.h"
#include "common/capture/trade.h"
#include "common/geometry/mesh.h"
#include "reconstructor/capture/capture_account.h"
#include "reconstructor/effort/effort_plan.h"
#include "reconstructor/effort/effort_probe.h"
#include "reconstructor/evaluation/held_out.h"
#include "reconstructor/evaluation/held_out_set.h"
#include "reconstructor/models/appearance_model.h"
#include "reconstructor/models/model_settings.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

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
  /// Before the first capture: no more than so many will come, which bounds what the model can come to hold.
  void expect_at_most(std::size_t captures) { most_captures_ = captures; }
  /// Before the first capture: the held-out views are judged on the pixels that this painter's mesh covers, not the one
  /// that is modelled, so that figures before and after refining compare.
  void judge_on_pixels_of(std::shared_ptr<const RayPainter> object) { object_ = std::move(object); }
  /// Before the first capture: their poses are not those of their source, and the saved model is to know them.
  void note_poses() { account_.note_poses(); }
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
  void leave_out(std::uint64_t captures) { account_.leave_out(captures); }
  void refuse_damaged(std::uint64_t captures) { account_.refuse_damaged(captures); }
  /// Forgets every capture: what is ingested from now on gives the bits that it gives a new one which follows the
  /// present `effort_record`.
  void restart();
  /// The same with another mesh.
  void restart_on(std::shared_ptr<const Mesh> mesh);

  const Mesh& mesh() const { return *mesh_; }
  const std::shared_ptr<const Mesh>& shared_mesh() const { return mesh_; }
  std::shared_ptr<const ModelSnapshot> snapshot() { return model_->snapshot(); }
  /// No capture follows: AppearanceModel::finish.
  void finish();
  /// AppearanceModel::give_snapshot.
  std::shared_ptr<const ModelSnapshot> give_snapshot() { return model_->give_snapshot(); }
  const AppearanceModel& model() const { return *model_; }
  const RayPainter& painter() const { return *painter_; }
  const std::shared_ptr<const RayPainter>& shared_painter() const { return painter_; }
  /// Of a long capture not all that were held out.
  const std::vector<HeldOutView>& held_out() const { return held_out_.views(); }
  const CaptureAccount& account() const { return account_; }

  /// How hard the model works: its effort level, and how much of what an image shows it updates.
  struct Effort {
    int level = 0;
    double update_fraction = 1;
    bool operator==(const Effort&) const = default;
  };
  Effort effort() const;
  /// Of a model of factorizations; else NaN.
  NumericalHealth health() const;
  /// `health`: as it was when it was last looked at.
  Trade trade(const NumericalHealth& health) const;
  MemoryAccount memory() const;
  /// By which this process has grown since there is a reconstruction, in bytes: now, or when it was finished.
  double resident_growth() const;
  /// What was decided to keep the budget, for a later run to follow; empty when nothing was.
  std::string effort_record() const { return effort_.record(); }

  /// The held-out views, seen by the model and by its constant-colour twin.
  struct Judgement {
    Scores model, constant;
  };
  Judgement judge(const StepsDone& progress = {});

 private:
  IngestReport take(const Capture& capture);
  void note_accepted(const Capture& capture, const IngestReport& report);
  void hold_out(const Capture& capture, const IngestReport& report);
  bool fit_memory(const Capture& first);
  void stay_within_memory();
  void choose_level();
  void fold_probe_at(int level);
  double error_on(const std::vector<HeldOutView>& views);

  double resident_before_, resident_at_finish_ = 0;
  std::shared_ptr<const Mesh> mesh_;
  std::unique_ptr<ModelSettings> asked_;
  std::shared_ptr<const RayPainter> painter_;
  std::shared_ptr<const RayPainter> object_;  ///< of the mesh whose pixels count; null: of the one that is modelled
  std::unique_ptr<AppearanceModel> model_;
  HeldOutSet held_out_;
  CaptureAccount account_;

  EffortPlan effort_;
  std::optional<CaptureSize> image_size_;  ///< of the first image
  std::size_t most_captures_ = std::numeric_limits<std::size_t>::max();
  double held_out_bytes_ = 0;
  bool memory_exceeded_ = false;  ///< although all that can be left out is: told once
  EffortProbe probe_;             ///< empty once the effort level is chosen
};

}  // namespace sheen
