// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/serve_watch.h"

#include <chrono>
#include <memory>
#include <stop_token>
#include <thread>

#include "common/base/errors.h"
#include "common/base/guarded_thread.h"
#include "common/base/log.h"
#include "common/base/sparing_log.h"
#include "reconstructor/models/model_registry.h"
#include "reconstructor/scene/mesh_scale.h"
#include "reconstructor/scene/model_choice.h"
#include "reconstructor/scene/placement_watch.h"

namespace sheen {

void open_window(std::optional<ViewerWindow>& window, const ModelKind& kind, const ViewerOptions& options) {
  try {
    window.emplace(kind, options);
  } catch (const DeviceError& error) {
    throw DeviceError(std::string(error.what()) + "; --headless captures without a window");
  }
}

void require_display() {
  std::optional<ViewerWindow> trial;
  open_window(trial, *model_kinds().front(), {.visible = false});
}

void wait_until(const std::function<bool()>& over, ViewerWindow*& window, const ViewerFeed& feed,
                const CaptureRequests& requests) {
  std::stop_source done;
  SparingLog log("capture");
  const auto tell = [&log](const std::exception_ptr& error) { log.tell(words_of(error), words_of(error)); };
  const auto is_over = [&] {
    bool is = false;
    guarded([&] { is = over(); }, tell);  // what cannot be told now can be later
    return is;
  };
  std::jthread look = guarded_thread(
      [&](const std::stop_token& closed) {
        while (!closed.stop_requested() && !is_over()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
        done.request_stop();
      },
      tell);
  if (window) {
    try {
      return window->run(feed, done.get_token(), requests);
    } catch (const Error& error) {
      log_warning("window", "the capture continues without it: " + std::string(error.what()));
      window = nullptr;
    }
  }
  look.join();
}

void LinkLog::look(const std::vector<LinkState>& links) {
  links_.resize(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const ReceiverStats &now = links[i].stats, &before = links_[i].stats;
    const LogFields at = links.size() > 1 ? LogFields{{"endpoint", links[i].endpoint}} : LogFields{};
    if (now.connected && !before.connected) log_info("link", "connected to the tracker", at);
    if (now.ended && !before.ended) log_info("link", "the tracker's source has ended", at);
    if (!now.connected && before.connected)
      log_info("link", now.ended ? "the tracker has ended and is disconnected" : "the tracker is disconnected", at);
    if (!now.last_error.empty() && now.last_error != before.last_error) log_warning("link", now.last_error, at);
  }
  links_ = links;
}

void watch_mesh(const Mesh& mesh, LiveDisplay& display, LoopObserver& observer) {
  const auto warn = [&display](const std::string& warning) {
    log_warning("mesh", warning);
    display.warn(warning);
  };
  observer.on_capture = [show = observer.on_capture, warn, placement = std::make_shared<PlacementWatch>(mesh, warn),
                         scale = ScaleWatch(mesh)](const Capture& capture) mutable {
    placement->look(capture);
    if (const std::string finding = scale.look(capture); !finding.empty()) warn(finding);
    if (show) show(capture);
  };
}

void watch_motion(const ModelKind& kind, LiveDisplay& display, LoopObserver& observer) {
  observer.on_capture = [show = observer.on_capture, &kind, &display, watch = MotionWatch(),
                         told = false](const Capture& capture) mutable {
    if (!told && capture.verdict == FrameVerdict::kKeyframe && capture.pose.usable()) {
      watch.look({capture.camera, capture.pose.camera_from_object}, capture.light);
      const std::string warning = motion_warning(kind, watch.motion());
      told = !warning.empty();
      if (told) log_warning("model", warning);
      if (told) display.warn(warning);
    }
    if (show) show(capture);
  };
}

std::function<void(const std::string&)> tells_findings(LiveDisplay& display) {
  return [&display](const std::string& finding) {
    log_warning("mesh", finding);
    display.warn(finding);
  };
}

}  // namespace sheen
