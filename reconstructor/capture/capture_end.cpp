// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/capture_end.h"

#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "common/base/errors.h"
#include "reconstructor/capture/capture_report.h"
#include "reconstructor/capture/saved_model.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kPoll{20};

struct Stopped {};

}  // namespace

void CaptureEnd::begin() {
  ending_ = std::async(std::launch::async, [this]() -> std::optional<Result> {
    try {
      return run();
    } catch (const Stopped&) {
      loop_.stop();
      return std::nullopt;
    }
  });
}

bool CaptureEnd::over() const {
  return ending_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

EndProgress CaptureEnd::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

bool CaptureEnd::stop(std::chrono::milliseconds patience) {
  stop_.request_stop();
  return ending_.wait_for(patience) == std::future_status::ready;
}

std::optional<CaptureEnd::Result> CaptureEnd::run() {
  fold_in_the_journal();
  Result result;
  std::optional<SmallFile> small;
  if (reconstruction_.account().counts().accepted > 0) {
    result.model = folder_ / kSessionModel;
    small = save_reconstruction(reconstruction_, reconstruction_.snapshot(), *result.model, folder_.string(), size_,
                                steps_of(EndStage::kSaving));
  }
  const Reconstruction::Judgement judged = reconstruction_.judge(steps_of(EndStage::kJudging));
  if (result.model && !small) note_judgement(judged.model, *result.model);
  nlohmann::json report = live_report(reconstruction_, judged, loop_.status());
  if (small) report["file"] = file_report(*result.model, *small);
  if (live_mesh_) report[live_mesh_->name()] = live_mesh_->report();
  result.report = std::make_shared<nlohmann::json>(std::move(report));
  return result;
}

void CaptureEnd::fold_in_the_journal() {
  show(EndStage::kFinishing, 0, 0);
  loop_.finish();
  for (; !loop_.finished(); std::this_thread::sleep_for(kPoll)) {
    const LoopStatus status = loop_.status();
    if (status.mesh_look && status.no_more_captures)
      show(EndStage::kRefining, status.mesh_look->done, status.mesh_look->steps);
    else
      show(EndStage::kFinishing, status.ingested, std::max(status.rebuild_until, status.journaled));
  }
  loop_.stop();
  if (const std::string error = loop_.status().error; !error.empty()) throw Error(error);
}

void CaptureEnd::show(EndStage stage, std::uint64_t done, std::uint64_t total) {
  if (stop_.stop_requested()) throw Stopped();
  const std::lock_guard lock(mutex_);
  progress_ = {stage, done, total};
}

StepsDone CaptureEnd::steps_of(EndStage stage) {
  show(stage, 0, 0);
  return [this, stage](std::size_t done, std::size_t steps) { show(stage, done, steps); };
}

}  // namespace sheen
