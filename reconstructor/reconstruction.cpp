// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/reconstruction.h"

#include <algorithm>

#include "common/log.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"

namespace sheen {

Reconstruction::Reconstruction(Mesh mesh, const SurfaceLightFieldOptions& options)
    : mesh_(std::make_shared<Mesh>(std::move(mesh))), model_(mesh_, options), painter_(*mesh_), asked_(options) {}

void Reconstruction::keep_within(const TradeoffWish& wish, const std::string& record, std::uint64_t captures) {
  wish_ = wish;
  if (!wish.image_ms) return;
  if (record.empty()) {
    control_.emplace(*wish.image_ms);
  } else {
    control_.emplace(*wish.image_ms, record, captures);
    memory_fitted_ = true;
    begin_at(*control_->rung());
  }
}

IngestReport Reconstruction::ingest(const Capture& capture) {
  if (!memory_fitted_ && wish_.bytes && capture.pose.usable()) fit_memory(capture);
  if (!control_) return take(capture);
  const std::uint64_t number = counts_.received;
  model_.set_share(control_->share(number));
  const IngestReport report = take(capture);
  if (!control_->rung()) {
    probe_.push_back(capture);
    if (updates_.count() == EffortControl::kProbeImages) choose_rung();
  } else if (report.status == IngestStatus::kAccepted) {
    double update_ms = 0;
    for (const auto& [stage, ms] : report.stage_ms) update_ms += ms;
    const double before = control_->share(number),
                 after = (control_->observe(number, update_ms), control_->share(number + 1));
    if (after != before)
      log_info("budget",
               after < before ? "images take too long: fewer rings an image are updated"
                              : "there is room: more rings an image are updated",
               {{"share", after}, {"budget_ms", control_->budget_ms()}});
  }
  return report;
}

void Reconstruction::fit_memory(const Capture& first) {
  memory_fitted_ = true;
  least_rung_ = finest_rung(*mesh_, first, asked_, least_rung_, *wish_.bytes);
  if (least_rung_ == rung_) return;
  log_info("memory", "a model with the maps asked for would not fit: coarser ones", {{"rung", least_rung_}});
  begin_at(least_rung_);
}

/// A function of the captures: the rings' memory is.
void Reconstruction::stay_within_memory() {
  while (static_cast<double>(model_.bytes()) > *wish_.bytes) {
    if (memory_step_ == memory_steps().size()) return;
    const TermLimit& limit = memory_steps()[memory_step_++];
    model_.limit_terms(limit.max_rank, limit.internal_rank, limit.block);
    log_info("memory", "the model outgrew it: fewer terms a ring are kept",
             {{"max_rank", limit.max_rank}, {"bytes", model_.bytes()}, {"asked", *wish_.bytes}});
    if (static_cast<double>(model_.bytes()) > *wish_.bytes && memory_step_ == memory_steps().size())
      log_warning("memory", "not even the smallest setting stays within it",
                  {{"bytes", model_.bytes()}, {"asked", *wish_.bytes}});
  }
}

/// By what the first images took; these are then taken in anew.
void Reconstruction::choose_rung() {
  const double image_ms = 1e3 * updates_.median_s();
  control_->set_rung(control_->choose_rung(image_ms, rung_, least_rung_));
  const std::vector<Capture> again = std::move(probe_);
  probe_.clear();
  if (*control_->rung() == rung_) return;
  log_info("budget", "the first images take too long: a coarser model is begun",
           {{"image_ms", image_ms}, {"budget_ms", control_->budget_ms()}, {"rung", *control_->rung()}});
  begin_at(*control_->rung());
  for (const Capture& capture : again) take(capture);
}

void Reconstruction::begin_at(int rung) {
  rung_ = rung;
  const std::uint64_t withdrawn = counts_.withdrawn;
  forget();
  counts_.received = counts_.withdrawn = withdrawn;
  model_.restart(at_rung(asked_, rung));
}

Reconstruction::Effort Reconstruction::effort() const {
  return {rung_, control_ ? control_->share(counts_.received) : 1.0};
}

IngestReport Reconstruction::take(const Capture& capture) {
  ++counts_.received;
  IngestReport report = model_.ingest(capture);
  switch (report.status) {
    case IngestStatus::kAccepted:
      ++counts_.accepted;
      account(report);
      if (wish_.bytes) stay_within_memory();
      break;
    case IngestStatus::kHeldOut:
      ++counts_.held_out;
      held_out_.push_back(make_held_out_view(capture, report.exposure_gain, painter_));
      break;
    case IngestStatus::kRefused:
      ++counts_.refused[report.reason];
      break;
  }
  return report;
}

bool Reconstruction::withdraw(const Capture& capture) {
  if (model_.began_with(capture) || !probe_.empty()) return false;
  const auto held_out = std::find_if(held_out_.begin(), held_out_.end(), [&](const HeldOutView& view) {
    return view.source_session == capture.source_session && view.sequence == capture.sequence;
  });
  if (held_out != held_out_.end()) {
    held_out_.erase(held_out);
    --counts_.held_out;
  } else {
    if (!model_.withdraw(capture)) return false;
    --counts_.accepted;
  }
  ++counts_.withdrawn;
  return true;
}

void Reconstruction::leave_out(std::uint64_t captures) {
  counts_.received += captures;
  counts_.withdrawn += captures;
}

void Reconstruction::refuse_damaged(std::uint64_t captures) {
  if (captures == 0) return;
  counts_.received += captures;
  counts_.refused["damaged file"] += captures;
}

void Reconstruction::restart() {
  if (control_ && control_->rung()) control_->follow_record_until(counts_.received);
  probe_.clear();
  forget();
  model_.restart(at_rung(asked_, rung_));
}

void Reconstruction::forget() {
  held_out_.clear();
  counts_ = {};
  stages_.clear();
  updates_ = {};
  rings_ = {};
  memory_step_ = 0;
}

void Reconstruction::account(const IngestReport& report) {
  double total_s = 0;
  for (const auto& [stage, ms] : report.stage_ms) {
    stages_[stage].add(1e-3 * ms);
    total_s += 1e-3 * ms;
  }
  updates_.add(total_s);
  rings_.updated += report.rings_updated;
  rings_.skipped += report.rings_skipped;
  rings_.left_out += report.rings_left_out;
}

double Reconstruction::images_per_s() const {
  return updates_.sum_s() > 0 ? static_cast<double>(updates_.count()) / updates_.sum_s() : 0;
}

Reconstruction::Judgement Reconstruction::judge(const StepsDone& progress) {
  const auto half = [&progress](std::size_t before) -> StepsDone {
    if (!progress) return {};
    return [&progress, before](std::size_t done, std::size_t views) { progress(before + done, 2 * views); };
  };
  return {score(held_out_, *fill_unseen(*snapshot()), painter_, half(0)),
          score(held_out_, *model_.constant_colour(), painter_, half(held_out_.size()))};
}

}  // namespace sheen
