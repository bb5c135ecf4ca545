// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <future>
#include <optional>
#include <string>
#include <thread>
#include <type_traits>

#include "common/base/guarded_thread.h"

namespace sheen {

/// For work that is given up when a stop signal arrives, however deep in a library it is: while one lives, the process
/// ends with exit status 1 and `message` on standard error when it has not ended by itself within 0.7 s of the signal.
/// Files are written beside their target and renamed, so none is left half. Needs `install_stop_signals`.
class EndOnStop {
 public:
  explicit EndOnStop(std::string message);
  EndOnStop(const EndOnStop&) = delete;
  EndOnStop& operator=(const EndOnStop&) = delete;

 private:
  std::jthread watcher_;
};

/// For work in parts of which the finished ones are kept. A part that is under way when a stop signal arrives cannot be
/// ended: it goes on in a thread that nobody waits for, and the process ends with this object, exit status 1. Needs
/// `install_stop_signals`.
class PartsUntilStop {
 public:
  PartsUntilStop() = default;
  ~PartsUntilStop();
  PartsUntilStop(const PartsUntilStop&) = delete;
  PartsUntilStop& operator=(const PartsUntilStop&) = delete;

  /// What `part` makes; nothing once a signal has arrived. What it refers to must outlive this object.
  template <typename Part>
  std::optional<std::invoke_result_t<Part&>> result(Part part) {
    std::packaged_task<std::invoke_result_t<Part&>()> task(std::move(part));
    auto made = task.get_future();
    detached_thread(std::move(task), [](const std::exception_ptr&) {});  // the future has what it throws
    while (made.wait_for(kLook) != std::future_status::ready)
      if (look()) return std::nullopt;
    return made.get();
  }
  bool stopped() const { return stopped_; }

 private:
  static constexpr std::chrono::milliseconds kLook{20};
  bool look();

  bool stopped_ = false;
};

}  // namespace sheen
