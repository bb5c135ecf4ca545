// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/reconstruction.h"

#include <algorithm>
#include <cmath>

#include "common/base/log.h"
#include "reconstructor/effort/resident_memory.h"
#include "reconstructor/radiance/capture_rules.h"

namespace sheen {
namespace {

double bytes_of(const HeldOutView& view) {
  return static_cast<double>(view.truth.size() + view.object.size() + view.inside.size());
}

}  // namespace

Reconstruction::Reconstruction(Mesh mesh, const ModelSettings& settings)
    : resident_before_(resident_memory().bytes),
      mesh_(std::make_shared<Mesh>(std::move(mesh))),
      asked_(settings.clone()),
      model_(asked_->make_model(mesh_)),
      painter_(*mesh_),
      effort_(settings.effort_levels()) {}

void Reconstruction::keep_within(const Limits& limits, const std::string& record, std::uint64_t captures,
                                 MeasuredLevels measured) {
  effort_.keep_within(limits, record, captures, std::move(measured));
  model_->restart(effort_.level());
}

void Reconstruction::begin_at(int level) {
  effort_.begin_at(level);
  model_->restart(effort_.level());
}

IngestReport Reconstruction::ingest(const Capture& capture) {
  EffortControl* control = effort_.control();
  if (!control) return take(capture);
  const std::uint64_t number = counts_.received;
  model_->set_update_fraction(control->update_fraction(number));
  const double held_out_bytes = held_out_bytes_;
  const IngestReport report = take(capture);
  if (report.status != IngestStatus::kAccepted) return report;
  if (!control->effort_level()) {
    probe_.push_back({capture, held_out_bytes, exposure_product(capture) > 0 ? report.exposure_gain : 1,
                      std::pow(10, -report.predicted_psnr_db / 10)});
    if (probe_.size() == EffortControl::kProbeImages) choose_level();
    return report;
  }
  double update_ms = 0;
  for (const auto& [stage, ms] : report.stage_ms) update_ms += ms;
  const double before = control->update_fraction(number),
               after = (control->observe(number, update_ms), control->update_fraction(number + 1));
  if (after != before)
    log_info("budget",
             after < before ? "images take too long: less of each image is updated"
                            : "there is room: more of each image is updated",
             {{"update_fraction", after}, {"budget_ms", control->budget_ms()}});
  return report;
}

/// True when the model has begun again, with coarser maps.
bool Reconstruction::fit_memory(const Capture& first) {
  const int before = effort_.level();
  const int level = model_->effort_level_within(first, before, *effort_.limits().bytes);
  effort_.set_memory_level(level);
  if (level == before) return false;
  log_info("memory", "a model with the maps asked for would not fit: coarser ones", {{"effort_level", level}});
  model_->rebuild(level);
  return true;
}

/// A function of the captures: what is counted is.
void Reconstruction::stay_within_memory() {
  const auto held = [&] {
    const MemoryAccount account = memory();
    return account.total() - account.probe;
  };
  while (held() > *effort_.limits().bytes && model_->reduce_memory())
    log_info("memory", "the model outgrew it: less detail is kept",
             {{"bytes", held()}, {"asked", *effort_.limits().bytes}});
  if (!memory_exceeded_ && held() > *effort_.limits().bytes) {
    memory_exceeded_ = true;
    log_warning("memory", "not even the smallest setting stays within it; a coarser mesh would",
                {{"bytes", held()}, {"asked", *effort_.limits().bytes}});
  }
}

MemoryAccount Reconstruction::memory() const {
  MemoryAccount account = model_->memory(image_size_.value_or(CaptureSize{}));
  account.held_out = held_out_bytes_;
  for (const ProbeImage& image : probe_) account.probe += size_of(image.capture).bytes;
  return account;
}

/// By what the first images took, and by what is lost on them where nothing was measured before.
void Reconstruction::choose_level() {
  const int begun_at = effort_.level();
  const double budget_ms = effort_.control()->budget_ms(), image_ms = 1e3 * updates_.median_s();
  int chosen = begun_at;
  if (!effort_.measured().empty()) {
    chosen = level_within(effort_.measured(), image_ms, begun_at, budget_ms);
    if (chosen != begun_at) fold_probe_at(chosen);
  } else if (image_ms > kBudgetMargin * budget_ms) {
    std::vector<HeldOutView> views;
    for (std::size_t i = 0; i < probe_.size(); i += 2)
      views.push_back(make_held_out_view(probe_[i].capture, probe_[i].known_gain, painter_));
    const double finest = error_on(views), unseen = std::max(predicted_error(), finest);
    while (chosen + 1 < effort_.levels() && 1e3 * updates_.median_s() > kBudgetMargin * budget_ms) {
      fold_probe_at(chosen + 1);
      // What coarser maps and fewer terms cannot hold of the images is added to the error on images that are not seen.
      const double lost_db = 10 * std::log10(1 + std::max(0.0, error_on(views) - finest) / unseen);
      log_info("budget", "a coarser model was tried on the first images",
               {{"effort_level", chosen + 1}, {"image_ms", 1e3 * updates_.median_s()}, {"lost_db", lost_db}});
      if (lost_db > kMostLoss_dB) {
        fold_probe_at(chosen);
        break;
      }
      ++chosen;
    }
  }
  effort_.control()->set_level(
      chosen == begun_at ? 0 : chosen);  // what only memory or target asked for is theirs to say again
  probe_ = {};
  if (chosen != begun_at)
    log_info("budget", "the first images take too long: a coarser model is begun",
             {{"image_ms", image_ms}, {"budget_ms", budget_ms}, {"effort_level", chosen}});
}

void Reconstruction::fold_probe_at(int level) {
  model_->rebuild(level);
  counts_.accepted = 0;
  std::erase_if(captures_, [](const KnownCapture& known) { return known.status == IngestStatus::kAccepted; });
  forget_work();
  const double held_out_bytes = held_out_bytes_;
  for (const ProbeImage& image : probe_) {
    held_out_bytes_ = image.held_out_bytes;
    note_accepted(image.capture, model_->ingest(image.capture));
  }
  held_out_bytes_ = held_out_bytes;
}

/// Mean over the later half of the first images, each predicted from those before; 0 where none could be.
double Reconstruction::predicted_error() const {
  double sum = 0;
  int predicted = 0;
  for (std::size_t i = probe_.size() / 2; i < probe_.size(); ++i) {
    if (!std::isfinite(probe_[i].predicted_error)) continue;
    sum += probe_[i].predicted_error;
    ++predicted;
  }
  return predicted > 0 ? sum / predicted : 0;
}

/// Mean square, encoded, over the object's pixels of views.
double Reconstruction::error_on(const std::vector<HeldOutView>& views) {
  SquaredError error;
  const auto model = snapshot()->filled();
  for (const HeldOutView& view : views) error += object_error(view, *model, painter_);
  return std::pow(10, -error.psnr_db() / 10);
}

Reconstruction::Effort Reconstruction::effort() const {
  return {effort_.level(), effort_.update_fraction(counts_.received)};
}

IngestReport Reconstruction::take(const Capture& capture) {
  ++counts_.received;
  IngestReport report = model_->ingest(capture);
  if (!image_size_ && model_->began_with(capture)) {
    image_size_ = size_of(capture);
    if (effort_.limits().bytes && fit_memory(capture)) report = model_->ingest(capture);
  }
  switch (report.status) {
    case IngestStatus::kAccepted:
      note_accepted(capture, report);
      break;
    case IngestStatus::kHeldOut:
      note(capture, report);
      ++counts_.held_out;
      held_out_.push_back(make_held_out_view(capture, report.exposure_gain, painter_));
      held_out_bytes_ += bytes_of(held_out_.back());
      break;
    case IngestStatus::kRefused:
      note(capture, report);
      ++counts_.refused[report.reason];
      break;
  }
  return report;
}

void Reconstruction::note(const Capture& capture, const IngestReport& report) {
  captures_.push_back({capture.source_session, capture.sequence, report.status, report.reason, report.repeated,
                       report.patches_skipped, report.exposure_gain});
}

void Reconstruction::note_accepted(const Capture& capture, const IngestReport& report) {
  note(capture, report);
  ++counts_.accepted;
  double total_s = 0;
  for (const auto& [stage, ms] : report.stage_ms) {
    stages_[stage].add(1e-3 * ms);
    total_s += 1e-3 * ms;
  }
  updates_.add(total_s);
  patches_.updated += report.patches_updated;
  patches_.skipped += report.patches_skipped;
  patches_.left_out += report.patches_left_out;
  if (effort_.limits().bytes) stay_within_memory();
}

Reconstruction::Withdrawn Reconstruction::withdraw(const Capture& capture) {
  const auto is_it = [&](const auto& other) {
    return other.source_session == capture.source_session && other.sequence == capture.sequence;
  };
  const auto known = std::find_if(captures_.begin(), captures_.end(), is_it);
  if (known == captures_.end() || model_->began_with(capture)) return Withdrawn::kNot;
  Withdrawn how = Withdrawn::kExactly;
  switch (known->status) {
    case IngestStatus::kRefused:
      if (--counts_.refused[known->reason] == 0) counts_.refused.erase(known->reason);
      break;
    case IngestStatus::kHeldOut:
      if (effort_.limits().bytes) how = Withdrawn::kNearly;  // it has taken memory, which is limited
      held_out_bytes_ = 0;
      std::erase_if(held_out_, is_it);
      for (const HeldOutView& view : held_out_) held_out_bytes_ += bytes_of(view);
      --counts_.held_out;
      break;
    case IngestStatus::kAccepted:
      if (!known->repeated) {
        if (!model_->withdraw(capture)) return Withdrawn::kNot;
        how = Withdrawn::kNearly;
      } else {
        patches_.skipped -= known->patches_skipped;
      }
      std::erase_if(probe_, [&](const ProbeImage& image) { return is_it(image.capture); });
      --counts_.accepted;
      break;
  }
  captures_.erase(known);
  ++counts_.withdrawn;
  return how;
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
  effort_.begin_again(counts_.received);
  held_out_.clear();
  held_out_bytes_ = 0;
  captures_.clear();
  counts_ = {};
  probe_ = {};
  image_size_.reset();
  forget_work();
  model_->restart(effort_.level());
}

void Reconstruction::forget_work() {
  stages_.clear();
  updates_ = {};
  patches_ = {};
  memory_exceeded_ = false;
}

void Reconstruction::finish() {
  resident_at_finish_ = resident_memory().bytes;
  model_->finish();
}

double Reconstruction::resident_growth() const {
  return std::max(resident_memory().bytes, resident_at_finish_) - resident_before_;
}

double Reconstruction::images_per_s() const {
  return updates_.sum_s() > 0 ? static_cast<double>(updates_.count()) / updates_.sum_s() : 0;
}

Reconstruction::Judgement Reconstruction::judge(const StepsDone& progress) {
  const auto half = [&progress](std::size_t before) -> StepsDone {
    if (!progress) return {};
    return [&progress, before](std::size_t done, std::size_t views) { progress(before + done, 2 * views); };
  };
  return {score(held_out_, *snapshot()->filled(), painter_, half(0)),
          score(held_out_, *model_->constant_colour(), painter_, half(held_out_.size()))};
}

}  // namespace sheen
