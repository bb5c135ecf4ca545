// SPDX-License-Identifier: Apache-2.0
#include "common/base/end_on_stop.h"

#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <mutex>

#include "common/base/log.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kLook{20};
constexpr std::chrono::milliseconds kPatience{700};
constexpr int kFailed = 1;

}  // namespace

EndOnStop::EndOnStop(std::string message)
    : watcher_(guarded_thread(
          [message = std::move(message)](const std::stop_token& done) {
            std::mutex mutex;
            std::condition_variable_any changed;
            std::unique_lock lock(mutex);
            const auto wait = [&](std::chrono::milliseconds time) {
              return changed.wait_for(lock, done, time, [&] { return done.stop_requested(); });
            };
            while (!stop_requested())
              if (wait(kLook)) return;
            if (wait(kPatience)) return;
            const ProgressPause pause;
            std::fprintf(stderr, "%s\n", message.c_str());
            ::_exit(kFailed);  // no destructors: the work may hold any lock
          },
          [](const std::exception_ptr& error) { log_error("stop", "signals end nothing here: " + words_of(error)); })) {
}

bool PartsUntilStop::look() {
  stopped_ = stopped_ || stop_requested();
  return stopped_;
}

PartsUntilStop::~PartsUntilStop() {
  if (!stopped_) return;
  std::cout.flush();
  std::fflush(stdout);
  ::_exit(kFailed);  // what it uses is about to go
}

}  // namespace sheen
