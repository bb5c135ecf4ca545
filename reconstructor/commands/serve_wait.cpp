// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/serve_wait.h"

#include <chrono>
#include <mutex>
#include <utility>

#include "common/base/errors.h"
#include "common/base/log.h"
#include "common/base/stop_signal.h"
#include "reconstructor/capture/live_shape.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kInterval{1000};  // of the page; the window needs no more

/// Shows what is received, and what is done with it.
class BeginningScreen {
 public:
  explicit BeginningScreen(const CaptureToBegin& capture) : capture_(capture) {}

  ArrivalObserver observer() {
    return {.on_link = [this](const std::vector<LinkState>& links) { capture_.log.look(links); },
            .on_capture =
                [this](const Capture& capture) {
                  auto copy = std::make_shared<const Capture>(capture);
                  const std::lock_guard lock(mutex_);
                  latest_ = std::move(copy);
                }};
  }

  const ViewerFeed& feed() const { return feed_; }

  /// When it is time to.
  void show(const WorkInHand& work) {
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + kInterval;
    std::unique_lock lock(mutex_);
    const std::shared_ptr<const Capture> latest = latest_;
    lock.unlock();
    feed_.publish({.capture = latest, .work = work});
    if (capture_.monitor)
      capture_.monitor->publish(
          state_before_first(capture_.names, capture_.links.states(), latest.get(), latest ? work.what : ""));
  }

 private:
  const CaptureToBegin& capture_;
  ViewerFeed feed_;
  std::chrono::steady_clock::time_point next_{};
  std::mutex mutex_;
  std::shared_ptr<const Capture> latest_;
};

}  // namespace

std::optional<FirstCapture::Found> wait_for_first(CaptureToBegin capture) {
  BeginningScreen screen(capture);
  FirstCapture first(capture.session, capture.links, capture.once, screen.observer());
  const WorkInHand work{"The first image begins the model.", 0,
                        "start a tracker: " + capture.names.trackers.front().command};
  wait_until(
      [&] {
        screen.show(work);
        return first.over() || stop_requested();
      },
      capture.window, screen.feed());
  const bool over = first.over();
  std::optional<FirstCapture::Found> found = first.take();
  if (!found && over) throw Error(capture.folder + ": the source has ended without an image that could begin a model");
  return over ? std::move(found) : std::nullopt;
}

std::shared_ptr<const Mesh> wait_for_shape(CaptureToBegin capture, int hold_out_every,
                                           const std::shared_ptr<const Mesh>& rough) {
  if (const auto known = shape_of_session(capture.folder)) {
    log_info("shape", "as the session has it", {{"triangles", known->triangles.size()}});
    return known;
  }
  BeginningScreen screen(capture);
  FirstShape first(capture.session, capture.links, capture.folder, hold_out_every, capture.once, rough,
                   screen.observer());
  wait_until(
      [&] {
        screen.show(first.work());
        return first.over() || stop_requested();
      },
      capture.window, screen.feed());
  const bool over = first.over();
  std::shared_ptr<const Mesh> found = first.take();
  if (found) require_no_origin("the shape", *found);
  return over ? found : nullptr;
}

}  // namespace sheen
