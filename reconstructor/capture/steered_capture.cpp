// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/steered_capture.h"

#include <optional>

#include "common/base/errors.h"
#include "common/base/log.h"
#include "common/base/utc_time.h"

namespace sheen {
namespace {

constexpr std::size_t kMostWaiting = 16;

}  // namespace

std::string SteeredCapture::ask(const SteerRequest& request) {
  const std::lock_guard lock(mutex_);
  if (waiting_.size() >= kMostWaiting) return "too much was asked at once; try again in a second";
  waiting_.push_back(request);
  return {};
}

void SteeredCapture::carry_out(CaptureLoop& loop) {
  for (;;) {
    SteerRequest request;
    {
      const std::lock_guard lock(mutex_);
      if (waiting_.empty()) return;
      request = std::move(waiting_.front());
      waiting_.pop_front();
    }
    const std::string line = utc_now() + " " + request.from + ": " + done(request, loop);
    log_info("steering", line);
    try {
      loop.write_down(kSteeringKey, line);
    } catch (const Error& error) {
      log_warning("steering", std::string("not written down: ") + error.what());
    }
    const std::lock_guard lock(mutex_);
    lines_.push_back(line);
  }
}

std::string SteeredCapture::done(const SteerRequest& request, CaptureLoop& loop) {
  using Action = SteerRequest::Action;
  switch (request.action) {
    case Action::kUndo:
      return take_back_last(loop);
    case Action::kHoldOut:
      return hold_out_next(loop);
    case Action::kPause:
      loop.pause();
      return "paused: images are stored and taken back";
    case Action::kGoOn:
      loop.go_on();
      return "images are added again";
    case Action::kNote:
      return "note: " + request.text;
    case Action::kFinish:
      break;
  }
  finishes_ = true;
  return "the capture is finished";
}

std::vector<std::string> SteeredCapture::lines() const {
  const std::lock_guard lock(mutex_);
  return lines_;
}

std::string take_back_last(CaptureLoop& loop) {
  try {
    const std::optional<std::uint64_t> taken = loop.withdraw_last();
    return taken ? "image " + std::to_string(*taken) + " is taken back" : "there is no image to take back";
  } catch (const Error& error) {
    return std::string("not taken back: ") + error.what();
  }
}

std::string hold_out_next(CaptureLoop& loop) {
  loop.hold_out_next();
  return "the next image is held out";
}

}  // namespace sheen
