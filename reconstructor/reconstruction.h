// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/capture.h"
#include "common/geometry/mesh.h"
#include "common/running_statistics.h"
#include "reconstructor/budget.h"
#include "reconstructor/evaluation/held_out.h"
#include "reconstructor/models/surface_light_field/surface_light_field.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

/// What became of the captures so far.
struct FrameCounts {
  std::uint64_t received = 0, accepted = 0, held_out = 0;
  std::map<std::string, std::uint64_t> refused;  ///< by reason
  std::uint64_t withdrawn = 0;                   ///< taken back by a person
};

/// One object being reconstructed: the model, the views that judge it, and the account of every capture. Live capture
/// and files go through the same `ingest`, so that the same captures in the same order give the same bits.
class Reconstruction {
 public:
  Reconstruction(Mesh mesh, const SurfaceLightFieldOptions& options);

  /// Before the first capture: keeps the time of an image and the model's memory within what is asked for, as far as
  /// the ladder goes (budget.h). `record`, of `captures` earlier ones: what an earlier run decided. Throws ConfigError.
  void keep_within(const TradeoffWish& wish, const std::string& record = {}, std::uint64_t captures = 0);
  const TradeoffWish& wish() const { return wish_; }

  IngestReport ingest(const Capture& capture);
  /// Takes a capture back, at once and nearly as if it had never been there (SurfaceLightField::withdraw). False when
  /// the model can only be made anew.
  bool withdraw(const Capture& capture);
  /// Counts captures that were withdrawn and so are not ingested.
  void leave_out(std::uint64_t captures);
  /// Counts captures whose files cannot be read among the refused.
  void refuse_damaged(std::uint64_t captures);
  /// Forgets every capture: what is ingested from now on gives the bits that it gives a new one.
  void restart();

  const Mesh& mesh() const { return *mesh_; }
  std::shared_ptr<const SurfaceLightFieldSnapshot> snapshot() { return model_.light_field_snapshot(); }
  const SurfaceLightField& model() const { return model_; }
  const RayPainter& painter() const { return painter_; }
  const std::vector<HeldOutView>& held_out() const { return held_out_; }
  const FrameCounts& counts() const { return counts_; }
  const std::map<std::string, RunningStatistics>& stages() const { return stages_; }
  const RunningStatistics& updates() const { return updates_; }  ///< all stages of an image together

  /// What became of the rings that the accepted images showed.
  struct RingCounts {
    std::uint64_t updated = 0, skipped = 0, left_out = 0;
  };
  const RingCounts& rings() const { return rings_; }
  /// How hard the model works: the rung of the ladder, and the share of an image's rings that it updates.
  struct Effort {
    int rung = 0;
    double share = 1;
    bool operator==(const Effort&) const = default;
  };
  Effort effort() const;
  /// What was decided to keep the budget, for a later run to follow; empty when nothing was.
  std::string effort_record() const { return control_ ? control_->record() : std::string(); }

  double images_per_s() const;  ///< accepted images over the time spent on ingesting them

  /// The held-out views, seen by the light field and by its constant-colour twin.
  struct Judgement {
    Scores light_field, constant;
  };
  Judgement judge(const StepsDone& progress = {});

 private:
  IngestReport take(const Capture& capture);
  void account(const IngestReport& report);
  void fit_memory(const Capture& first);
  void stay_within_memory();
  void choose_rung();
  void begin_at(int rung);
  void forget();

  std::shared_ptr<const Mesh> mesh_;
  SurfaceLightField model_;
  RayPainter painter_;
  std::vector<HeldOutView> held_out_;
  FrameCounts counts_;
  std::map<std::string, RunningStatistics> stages_;
  RunningStatistics updates_;
  RingCounts rings_;

  TradeoffWish wish_;
  SurfaceLightFieldOptions asked_;  ///< before any rung's limits
  std::optional<EffortControl> control_;
  int rung_ = 0, least_rung_ = 0;
  bool memory_fitted_ = false;
  std::size_t memory_step_ = 0;  ///< how many of `memory_steps` have been taken
  std::vector<Capture> probe_;   ///< what came before the rung is chosen
};

}  // namespace sheen
