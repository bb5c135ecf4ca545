// SPDX-License-Identifier: Apache-2.0
#include "common/base/repeated_work.h"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>

#include "common/base/guarded_thread.h"
#include "common/base/sparing_log.h"

namespace sheen {

RepeatedWork::RepeatedWork(const std::string& component, std::chrono::milliseconds pause, std::function<void()> round) {
  const auto log = std::make_shared<SparingLog>(component);
  const auto tell = [log](const std::exception_ptr& error) {
    const std::string what = words_of(error);
    log->tell(what, "goes on after: " + what);
  };
  thread_ = guarded_thread(
      [pause, round = std::move(round), tell](const std::stop_token& stop) {
        std::mutex mutex;
        std::condition_variable_any stopped;
        std::unique_lock lock(mutex);
        do {
          guarded(round, tell);
        } while (!stopped.wait_for(lock, stop, pause, [&] { return stop.stop_requested(); }));
      },
      tell);
}

}  // namespace sheen
