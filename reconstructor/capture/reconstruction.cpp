// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/reconstruction.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <set>
#include <utility>

#include "common/base/log.h"
#include "common/capture/linear_capture.h"
#include "reconstructor/effort/resident_memory.h"
#include "reconstructor/models/factored_model.h"

namespace sheen {
namespace {

/// Tells the control what the image with this number took, and the log when the images after it get another fraction.
void adapt_update_fraction(EffortControl& control, std::uint64_t number, const IngestReport& report) {
  double update_ms = 0;
  for (const auto& [stage, ms] : report.stage_ms) update_ms += ms;
  const double before = control.update_fraction(number);
  control.observe(number, update_ms);
  const double after = control.update_fraction(number + 1);
  if (after == before) return;
  log_info("budget",
           after < before ? "images take too long: less of each image is updated"
                          : "there is room: more of each image is updated",
           {{"update_fraction", after}, {"budget_ms", control.budget_ms()}});
}

/// Once for each source, however many models are made of it, and again for a camera of it of which something else is
/// known.
void say_what_is_known_of_light(const Capture& capture) {
  constexpr std::size_t kMostSources = 64;  // names that somebody makes up fill neither the memory nor the log
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::lock_guard lock(mutex);
  const std::string known = capture.source_session + ": " + photometric_knowledge(capture);
  if (said.size() >= kMostSources || !said.insert(known).second) return;
  if (capture.photometry && !capture.photometry->vignette.none()) return;
  log_info("light", std::string("what the camera makes of light: ") + photometric_knowledge(capture) +
                        "; `sheen-tracker calibrate photometric` measures it");
}

}  // namespace

Reconstruction::Reconstruction(Mesh mesh, const ModelSettings& settings)
    : resident_before_(resident_memory().bytes),
      mesh_(std::make_shared<Mesh>(std::move(mesh))),
      asked_(settings.clone()),
      painter_(std::make_shared<RayPainter>(*mesh_)),
      model_(asked_->make_model(mesh_, painter_->scene())),
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
  const std::uint64_t number = account_.counts().received;
  model_->set_update_fraction(control->update_fraction(number));
  const double held_out_bytes = held_out_bytes_;
  const IngestReport report = take(capture);
  if (report.status != IngestStatus::kAccepted) return report;
  if (!control->effort_level()) {
    probe_.add(capture, report, held_out_bytes);
    if (probe_.full()) choose_level();
    return report;
  }
  adapt_update_fraction(*control, number, report);
  return report;
}

/// True when the model has started again, with coarser maps.
bool Reconstruction::fit_memory(const Capture& first) {
  const int before = effort_.level();
  const int level =
      model_->effort_level_within(first, before, {*effort_.limits().bytes, most_captures_, effort_.limits().shown});
  effort_.set_memory_level(level);
  if (level == before) return false;
  log_info("memory", "a model with these maps would not fit: coarser ones are used", {{"effort_level", level}});
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
    log_info("memory", "the model grew beyond the limit: less detail is kept",
             {{"bytes", held()}, {"asked", *effort_.limits().bytes}});
  if (!memory_exceeded_ && held() > *effort_.limits().bytes) {
    memory_exceeded_ = true;
    log_warning("memory", "even the smallest setting exceeds the limit; use a coarser mesh",
                {{"bytes", held()}, {"asked", *effort_.limits().bytes}});
  }
}

MemoryAccount Reconstruction::memory() const {
  MemoryAccount account = model_->memory(image_size_.value_or(CaptureSize{}));
  if (!effort_.limits().shown) account = account.unshown();
  account.held_out = held_out_bytes_;
  account.probe = probe_.bytes();
  return account;
}

void Reconstruction::choose_level() {
  const int begun_at = effort_.level();
  const int chosen =
      probe_.choose(effort_.measured(), begun_at, effort_.levels(), effort_.control()->budget_ms(), *painter_,
                    {.fold_at = [this](int level) { fold_probe_at(level); },
                     .image_ms = [this] { return 1e3 * account_.updates().median_s(); },
                     .error_on = [this](const auto& views) { return error_on(views); }});
  // What only memory or target asked for is theirs to say again.
  effort_.control()->set_level(chosen == begun_at ? 0 : chosen);
  probe_ = {};
}

void Reconstruction::fold_probe_at(int level) {
  model_->rebuild(level);
  account_.forget_accepted();
  memory_exceeded_ = false;
  const double held_out_bytes = held_out_bytes_;
  for (const EffortProbe::Image& image : probe_.images()) {
    held_out_bytes_ = image.held_out_bytes;
    note_accepted(image.capture, model_->ingest(image.capture));
  }
  held_out_bytes_ = held_out_bytes;
}

/// Mean square, encoded, over the object's pixels of views.
double Reconstruction::error_on(const std::vector<HeldOutView>& views) {
  SquaredError error;
  const auto model = snapshot()->filled();
  for (const HeldOutView& view : views) error += object_error(view, *model, *painter_);
  return std::pow(10, -error.psnr_db() / 10);
}

Reconstruction::Effort Reconstruction::effort() const {
  return {effort_.level(), effort_.update_fraction(account_.counts().received)};
}

NumericalHealth Reconstruction::health() const {
  const auto* const factored = dynamic_cast<const FactoredModel*>(model_.get());
  return factored ? factored->health() : NumericalHealth{};
}

Trade Reconstruction::trade(const NumericalHealth& health) const {
  const Effort now = effort();
  const RunningStatistics& updates = account_.updates();
  return {.favour = limits().favour,
          .effort_level = now.level,
          .effort_levels = effort_.levels(),
          .update_fraction = now.update_fraction,
          .image_ms = updates.count() > 0 ? 1e3 * updates.median_s() : 0,
          .budget_ms = limits().image_ms,
          .resident_bytes = resident_memory().bytes,
          .grown_bytes = resident_growth(),
          .memory_bytes = limits().bytes,
          .target_db = limits().psnr_db,
          .health = health};
}

IngestReport Reconstruction::take(const Capture& capture) {
  account_.receive();
  say_what_is_known_of_light(capture);
  IngestReport report = model_->ingest(capture);
  if (!image_size_ && model_->began_with(capture)) {
    image_size_ = size_of(capture);
    if (effort_.limits().bytes && fit_memory(capture)) report = model_->ingest(capture);
  }
  if (report.status == IngestStatus::kAccepted) {
    note_accepted(capture, report);
  } else {
    account_.note(capture, report);
    if (report.status == IngestStatus::kHeldOut) hold_out(capture, report);
  }
  return report;
}

void Reconstruction::note_accepted(const Capture& capture, const IngestReport& report) {
  account_.note(capture, report);
  if (effort_.limits().bytes) stay_within_memory();
}

void Reconstruction::hold_out(const Capture& capture, const IngestReport& report) {
  if (!held_out_.takes_next()) return;
  held_out_.add(make_held_out_view(capture, report.exposure_gain, object_ ? *object_ : *painter_));
  held_out_bytes_ = held_out_.bytes();
}

Reconstruction::Withdrawn Reconstruction::withdraw(const Capture& capture) {
  const KnownCapture* known = account_.find(capture);
  if (!known || model_->began_with(capture)) return Withdrawn::kNot;
  Withdrawn how = Withdrawn::kExactly;
  if (known->status == IngestStatus::kHeldOut) {
    if (effort_.limits().bytes) how = Withdrawn::kNearly;  // it has taken memory, which is limited
    held_out_.erase(capture.source_session, capture.sequence);
    held_out_bytes_ = held_out_.bytes();
  }
  if (known->status == IngestStatus::kAccepted) {
    if (!known->repeated) {
      if (!model_->withdraw(capture)) return Withdrawn::kNot;
      how = Withdrawn::kNearly;
    }
    probe_.leave_out(capture);
  }
  account_.withdraw(*known);
  return how;
}

void Reconstruction::restart() {
  effort_.begin_again(account_.counts().received);
  account_ = {};
  held_out_.clear();
  held_out_bytes_ = 0;
  probe_ = {};
  image_size_.reset();
  memory_exceeded_ = false;
  model_->restart(effort_.level());
}

void Reconstruction::restart_on(std::shared_ptr<const Mesh> mesh) {
  mesh_ = std::move(mesh);
  model_.reset();  // before there is another
  painter_ = std::make_shared<RayPainter>(*mesh_);
  model_ = asked_->make_model(mesh_, painter_->scene());
  restart();
}

void Reconstruction::finish() {
  resident_at_finish_ = resident_memory().bytes;
  model_->finish();
}

double Reconstruction::resident_growth() const {
  return std::max(resident_memory().bytes, resident_at_finish_) - resident_before_;
}

Reconstruction::Judgement Reconstruction::judge(const StepsDone& progress) {
  const auto half = [&progress](std::size_t before) -> StepsDone {
    if (!progress) return {};
    return [&progress, before](std::size_t done, std::size_t views) { progress(before + done, 2 * views); };
  };
  return {score(held_out_.views(), *snapshot()->filled(), *painter_, half(0)),
          score(held_out_.views(), *model_->constant_colour(), *painter_, half(held_out_.views().size()))};
}

}  // namespace sheen
